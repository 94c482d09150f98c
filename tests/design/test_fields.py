"""`tribo-design synthesize --help` lists each field that DESIGN.yaml may have."""

import re
import typing

from pydantic import BaseModel

from tribo_design.config import Design
from tribo_design.fields import FIELDS


def names_of(model):
    """Each field's own name, of the groups inside as well."""
    for name, field in model.model_fields.items():
        yield name
        for part in (field.annotation, *typing.get_args(field.annotation)):
            if isinstance(part, type) and issubclass(part, BaseModel):
                yield from names_of(part)


def test_every_field_is_listed():
    names = set(names_of(Design))
    assert len(names) > 40
    assert names - set(re.findall(r"\w+", FIELDS)) == set()
