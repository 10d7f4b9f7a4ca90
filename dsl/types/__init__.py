# SPDX-License-Identifier: Apache-2.0
"""The types of the language, their intervals and their units.

Takes nothing of hypgen. Gives the types of ``model_types``, interval arithmetic and units of measurement.
"""

from hypgen.dsl.types.model_types import (
    BOOL,
    FLOAT,
    INT,
    INT32_MAX,
    INT32_MIN,
    PROB,
    Array,
    Bool,
    Enum,
    Float,
    Int,
    Record,
    Type,
    Variant,
    digits_of,
    flat_indices,
    is_finite,
    length_of,
    low_of,
    size_of,
)

__all__ = [
    "Array",
    "BOOL",
    "Bool",
    "Enum",
    "FLOAT",
    "Float",
    "INT",
    "INT32_MAX",
    "INT32_MIN",
    "Int",
    "PROB",
    "Record",
    "Type",
    "Variant",
    "digits_of",
    "flat_indices",
    "is_finite",
    "length_of",
    "low_of",
    "size_of",
]
