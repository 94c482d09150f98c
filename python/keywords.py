"""keywords.py: python/tribo/_keywords.py, what a type checker and an editor know of the keywords, from the table of keys.

    tools/design/.venv/bin/python -B python/keywords.py > python/tribo/_keywords.py.new && mv python/tribo/_keywords.py.new python/tribo/_keywords.py
"""

from tribo import _core, _parts

PARTS = (_parts.Loop, _parts.Friction, _parts.Compensator, _parts.Guard, _parts.FeedForward)


def lines():
    yield '"""The keywords of run and of each part. Made by python/keywords.py of the table of keys."""\n'
    yield "from collections.abc import Mapping, Sequence\nfrom typing import Literal, TypedDict"
    for name, keywords in (("Run", _core.keywords_of()), *((part.__name__, _core.keywords_of(part._groups, part._within)) for part in PARTS)):
        yield f"\n\nclass {name}Keys(TypedDict, total=False):"
        yield from (f"    {keyword}: {_core.annotation_of(key)}" for keyword, key in keywords.items() if keyword != "arithmetic")


def text():
    return "\n".join(lines()) + "\n"


if __name__ == "__main__":
    print(text(), end="")
