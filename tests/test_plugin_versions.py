"""What is kept of an interrupted check or sweep goes with one version of an estimator, wherever it comes from."""

import sys

import pytest

from imubench.checks.runs import Subject
from imubench.checks.scenario import Named
from imubench.estimators import ESTIMATORS
from imubench.plugin_versions import OURS, estimator_version, versions
from imubench.plugins import find_estimator
from tests.test_plugins import imports_as_before, installed, written  # noqa: F401

WAYS = ("file", "module", "entry point")


@pytest.fixture(params=WAYS)
def asked_for(request, tmp_path):
    """An estimator's name, by each way, in a folder with a second module beside it."""
    stem = f"versioned_{request.param.replace(' ', '_')}"
    file = written(tmp_path / f"{stem}.py")
    written(tmp_path / "beside_it.py", "NUMBER = 1\n")
    if request.param == "file":
        return f"{file}:estimate", file
    installed(tmp_path, stem.replace("_", "-"), f"{stem} = {stem}:estimate")
    return (f"{stem}:estimate" if request.param == "module" else stem), file


@pytest.mark.parametrize("which", ["its own", "one beside it"])
def test_it_changes_with_the_estimators_module_and_those_beside_it(asked_for, which):
    """A check did not see that the package behind an entry point had changed, a sweep not what lies beside a file."""
    name, file = asked_for
    subject = Subject(name, Named("hinge-hand"), 60.0)
    before = estimator_version(find_estimator(name)), subject.key, versions({name: name})
    assert before == (estimator_version(find_estimator(name)), subject.key, versions({name: name}))
    changed = file if which == "its own" else file.with_name("beside_it.py")
    changed.write_text(changed.read_text() + "\nMORE = 2\n")
    sys.modules.pop(file.stem, None)  # as in another process
    after = estimator_version(find_estimator(name)), subject.key, versions({name: name})
    assert all(was != now for was, now in zip(before, after, strict=True))


def test_ours_are_told_by_the_hash_of_all_our_code():
    assert {estimator_version(e) for e in ESTIMATORS.values()} == {OURS}


def test_a_packages_version_is_told(tmp_path):
    written(tmp_path / "told_package" / "__init__.py")
    installed(tmp_path, "told-package", "told = told_package:estimate")
    written(tmp_path / "told_package-1.2.dist-info" / "top_level.txt", "told_package\n")
    assert estimator_version(find_estimator("told")).startswith("told-package 1.2, ")
