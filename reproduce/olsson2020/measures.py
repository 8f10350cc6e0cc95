"""The names that claims.toml measures its claims by; each function takes the results and returns number and words."""

from collections.abc import Callable
from functools import partial

from imubench.reproduce.claims import Measured
from imubench.reproduce.olsson2020.measures_acceptance import success, table_maxae, table_rmsae, worst_of_table
from imubench.reproduce.olsson2020.measures_time import (
    apart_from_all,
    error_4_during_9,
    final_difference_of_sequences,
    gain_of_selection_3,
    preference_for_rest,
    settled_2,
    settled_4,
    uninformative_gyro_samples,
)
from imubench.reproduce.olsson2020.measures_weights import (
    SLOW_PLANAR,
    log_weight_of_wrong_pairing,
    rmsae_at,
    worst_rmsae_between,
    wrong_minima_at,
)
from imubench.reproduce.olsson2020.results import KINDS, PLAIN, WITH_BIAS, Results
from imubench.reproduce.olsson2020.settings import MOTIONS, N_MAX, SEQUENCES

Measure = Callable[[Results], Measured]

MEASURES: dict[str, Measure] = {
    "wrong_minima_at_small_weight": partial(wrong_minima_at, which=0),
    "wrong_minima_at_large_weight": partial(wrong_minima_at, which=-1),
    "worst_rmsae_on_plateau": partial(worst_rmsae_between, motions=MOTIONS, low=10.0, high=1e5),
    "worst_rmsae_of_slow_planar": partial(worst_rmsae_between, motions=SLOW_PLANAR, low=0.0, high=10.0),
    "log_weight_of_wrong_pairing": log_weight_of_wrong_pairing,
    "settled_2_selected": partial(settled_2, size=N_MAX),
    "settled_2_all": partial(settled_2, size=0),
    "final_difference_of_sequences": final_difference_of_sequences,
    "gain_of_selection_3": gain_of_selection_3,
    "error_4_during_9": error_4_during_9,
    "settled_4": settled_4,
    "uninformative_gyro_samples": uninformative_gyro_samples,
    "preference_for_rest": preference_for_rest,
    "worst_maxae_clean": partial(worst_of_table, measure=table_maxae, kinds=(PLAIN,)),
    "worst_maxae_biased": partial(worst_of_table, measure=table_maxae, kinds=(WITH_BIAS,)),
    "worst_rmsae": partial(worst_of_table, measure=table_rmsae, kinds=(PLAIN, WITH_BIAS)),
}
MEASURES |= {f"rmsae_{m}_at_smallest_weight": partial(rmsae_at, motion=m, which=0) for m in (7, 12, 14)}
MEASURES |= {f"rmsae_{m}_at_largest_weight": partial(rmsae_at, motion=m, which=-1) for m in (3, 10)}
MEASURES |= {f"apart_from_all_{n}": partial(apart_from_all, size=n) for n in (1000, 500, 250, 125)}
for _name in SEQUENCES:
    MEASURES |= {f"success_{n}_{_name}": partial(success, name=_name, n_min=n) for n in (3, 10)}
    for _kind, _which in KINDS.items():
        MEASURES[f"rmsae_{_kind}_{_name}"] = partial(table_rmsae, name=_name, which=_which)
        MEASURES[f"maxae_{_kind}_{_name}"] = partial(table_maxae, name=_name, which=_which)
