"""Under which name, version, licence and date a dataset is published: what its maker alone can say."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date, datetime
from typing import Any

from imubench.errors import InputError, shown

KEYS = ("licence", "version", "published", "creator", "url")
SEMANTIC = re.compile(r"(0|[1-9]\d*)\.(0|[1-9]\d*)\.(0|[1-9]\d*)(-[0-9A-Za-z.-]+)?(\+[0-9A-Za-z.-]+)?")
SPDX = {  # identifier of a licence -> that of the Hugging Face hub
    "CC0-1.0": "cc0-1.0",
    "CC-BY-4.0": "cc-by-4.0",
    "CC-BY-SA-4.0": "cc-by-sa-4.0",
    "CC-BY-NC-4.0": "cc-by-nc-4.0",
    "CC-BY-NC-SA-4.0": "cc-by-nc-sa-4.0",
    "CC-BY-NC-ND-4.0": "cc-by-nc-nd-4.0",
    "CC-BY-ND-4.0": "cc-by-nd-4.0",
    "PDDL-1.0": "pddl",
    "ODbL-1.0": "odbl",
    "ODC-By-1.0": "odc-by",
    "CDLA-Permissive-2.0": "cdla-permissive-2.0",
    "MIT": "mit",
    "Apache-2.0": "apache-2.0",
    "BSD-3-Clause": "bsd-3-clause",
}


@dataclass(frozen=True)
class Terms:
    """What a spec says of publication; empty where it does not."""

    licence: str = ""  # an SPDX identifier, or text
    version: str = "1.0.0"
    published: date | None = None
    creator: str = ""
    url: str = ""

    @property
    def spdx(self) -> str:
        """The SPDX identifier of the licence; empty where it is another one or none."""
        return next((name for name in SPDX if name.lower() == self.licence.lower()), "")

    @property
    def missing(self) -> tuple[str, ...]:
        """The keys that readers of croissant.json miss."""
        return tuple(key for key in ("licence", "published") if not getattr(self, key))


def parse_terms(table: Mapping[str, Any], where: str) -> Terms:
    """Return what a spec says of publication; `InputError` for a version or a date that is none."""
    version = line_of(table, "version", Terms.version, where)
    if not SEMANTIC.fullmatch(version):
        raise InputError(f"{where}: version: expected one such as 1.0.0 (MAJOR.MINOR.PATCH), got {shown(version)}")
    day = table.get("published")
    if day is not None and (not isinstance(day, date) or isinstance(day, datetime)):
        raise InputError(f"{where}: published: expected a date such as 2030-01-31, without quotes, got {shown(day)}")
    url = line_of(table, "url", "", where)
    if url and not re.fullmatch(r"https?://\S+", url):
        raise InputError(f"{where}: url: expected one that begins with https:// or http://, got {shown(url)}")
    licence, creator = line_of(table, "licence", "", where), line_of(table, "creator", "", where)
    return Terms(licence, version, day, creator, url)


def line_of(table: Mapping[str, Any], key: str, default: str, where: str) -> str:
    """Return a text of one line; `InputError` for anything else."""
    value = table.get(key, default)
    if not isinstance(value, str) or "\n" in value or "\r" in value:
        raise InputError(f"{where}: {key}: expected a line of text, got {shown(value)}")
    return value


def cited(name: str, terms: Terms, made_with: str) -> str:
    """Return a BibTeX entry for a dataset that is published under these terms."""
    key = re.sub(r"\W+", "-", name, flags=re.ASCII).strip("-").lower() or "dataset"
    fields = {"title": name, "author": terms.creator, "version": terms.version, "url": terms.url, "note": made_with}
    if terms.published is not None:
        fields["year"] = str(terms.published.year)
    told = [f"  {name} = {{{_escaped(value)}}}" for name, value in fields.items() if value]
    return f"@misc{{{key},\n" + ",\n".join(told) + "\n}"


def _escaped(text: str) -> str:
    """Return text in which no brace closes the entry."""
    return re.sub(r"[{}\\]", "", text)
