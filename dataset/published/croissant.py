"""croissant.json: a dataset in Croissant 1.1 (JSON-LD), by which search engines and machine-learning tools find it.

Its tables are file sets beside it, one record set each; every split is a record of the enumeration `splits`, which the
column `split` of both tables refers to.
"""

import json
from collections.abc import Mapping
from typing import Any

import pyarrow as pa

from imubench.dataset import columns, rows
from imubench.dataset.published.columns import told
from imubench.dataset.published.tables import TABLES, parts
from imubench.dataset.published.terms import cited
from imubench.dataset.published.text import described, made_with
from imubench.dataset.spec import Spec

CROISSANT = "croissant.json"
CONFORMS_TO = "http://mlcommons.org/croissant/1.1"
PARQUET = "application/x-parquet"
KEYWORDS = ("inertial measurement unit", "inertial motion capture", "joint calibration", "simulated", "time series")
CONTEXT: dict[str, Any] = {  # that of the specification
    "@language": "en",
    "@vocab": "https://schema.org/",
    "arrayShape": "cr:arrayShape",
    "citeAs": "cr:citeAs",
    "column": "cr:column",
    "conformsTo": "dct:conformsTo",
    "containedIn": "cr:containedIn",
    "cr": "http://mlcommons.org/croissant/",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "dct": "http://purl.org/dc/terms/",
    "description": {"@container": "@language"},
    "equivalentProperty": "cr:equivalentProperty",
    "examples": {"@id": "cr:examples", "@type": "@json"},
    "extract": "cr:extract",
    "field": "cr:field",
    "fileProperty": "cr:fileProperty",
    "fileObject": "cr:fileObject",
    "fileSet": "cr:fileSet",
    "format": "cr:format",
    "includes": "cr:includes",
    "isArray": "cr:isArray",
    "isLiveDataset": "cr:isLiveDataset",
    "jsonPath": "cr:jsonPath",
    "key": "cr:key",
    "md5": "cr:md5",
    "name": {"@container": "@language"},
    "parentField": "cr:parentField",
    "path": "cr:path",
    "recordSet": "cr:recordSet",
    "references": "cr:references",
    "regex": "cr:regex",
    "repeated": "cr:repeated",
    "replace": "cr:replace",
    "samplingRate": "cr:samplingRate",
    "sc": "https://schema.org/",
    "separator": "cr:separator",
    "source": "cr:source",
    "subField": "cr:subField",
    "transform": "cr:transform",
}
TYPES = {
    pa.int32(): "cr:Int32",
    pa.int64(): "cr:Int64",
    pa.float32(): "cr:Float32",
    pa.float64(): "cr:Float64",
    pa.string(): "sc:Text",
}


def croissant(spec: Spec, manifest: Mapping[str, Any]) -> str:
    """Return the content of croissant.json; what a spec does not say of publication is left out."""
    terms = spec.terms
    licence = f"https://spdx.org/licenses/{terms.spdx}.html" if terms.spdx else terms.licence
    content: dict[str, Any] = {
        "@context": CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": CONFORMS_TO,
        "name": spec.name,
        "description": described(spec, manifest),
        "license": licence,
        "version": terms.version,
        "datePublished": terms.published.isoformat() if terms.published else "",
        "creator": {"@type": "sc:Person", "name": terms.creator} if terms.creator else "",
        "url": terms.url,
        "citeAs": cited(spec.name, terms, made_with(manifest)),
        "keywords": list(KEYWORDS),
        "distribution": [_file_set(table) for table in TABLES],
        "recordSet": [
            _splits(list(parts(manifest, "recordings"))),
            _record_set("recordings", "One row a recording: everything that was drawn.", rows.schema(spec), spec),
            _record_set("samples", "One row a sample: signals and truth.", columns.schema(spec), spec),
        ],
    }
    return json.dumps({key: value for key, value in content.items() if value}, indent=1, ensure_ascii=False) + "\n"


def _file_set(table: str) -> dict[str, Any]:
    return {
        "@type": "cr:FileSet",
        "@id": f"{table}-files",
        "name": f"{table}-files",
        "description": f"The Parquet files of the table of {table}, each of one split, which its name begins with.",
        "encodingFormat": PARQUET,
        "includes": f"{table}/*.parquet",
    }


def _splits(names: list[str]) -> dict[str, Any]:
    name = {"@type": "cr:Field", "@id": "splits/name", "name": "name", "dataType": "sc:Text"}
    return {
        "@type": "cr:RecordSet",
        "@id": "splits",
        "name": "splits",
        "description": "The splits that have recordings; all recordings of a rig are in one of them.",
        "dataType": "cr:Split",
        "key": {"@id": "splits/name"},
        "field": [name],
        "data": [{"splits/name": split} for split in names],
    }


def _record_set(table: str, description: str, schema: pa.Schema, spec: Spec) -> dict[str, Any]:
    keys = ["recording"] if table == "recordings" else ["recording", "time"]
    return {
        "@type": "cr:RecordSet",
        "@id": table,
        "name": table,
        "description": description,
        "key": [{"@id": f"{table}/{key}"} for key in keys],
        "field": [_field(table, field) for field in schema],
    }


def _field(table: str, field: pa.Field) -> dict[str, Any]:
    said, name = told(field.name), f"{table}/{field.name}"
    unit = f" [{said.unit}]" if said.unit else ""
    found: dict[str, Any] = {
        "@type": "cr:Field", "@id": name, "name": field.name, "description": f"{said.meaning}{unit}"
    }  # fmt: skip
    source = {"fileSet": {"@id": f"{table}-files"}, "extract": {"column": field.name}}
    kind = field.type
    if field.name == "split":
        return found | {"dataType": "sc:Text", "source": source, "references": {"field": {"@id": "splits/name"}}}
    if pa.types.is_fixed_size_list(kind):
        shape = {"isArray": True, "arrayShape": str(kind.list_size)}
        return found | {"dataType": TYPES[kind.value_type], **shape, "source": source}
    if pa.types.is_list(kind):  # of structures
        parts_of = [
            {
                "@type": "cr:Field",
                "@id": f"{name}/{part.name}",
                "name": part.name,
                "dataType": TYPES[part.type],
                "source": source | {"transform": {"jsonPath": part.name}},
            }
            for part in kind.value_type
        ]
        return found | {"isArray": True, "arrayShape": "-1", "subField": parts_of}
    return found | {"dataType": TYPES[kind], "source": source}
