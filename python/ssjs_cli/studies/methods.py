"""Which methods a study sets side by side: those that the estimator lists, never a list of our own."""

from ssjs_cli.config import METHOD_KEY, field_descriptions
from ssjs_cli.errors import UserError, nearest_hint

ALL = "all"


def known_methods() -> tuple[str, ...]:
    return field_descriptions()[METHOD_KEY].choices


def chosen_methods(text: str | None) -> list[str]:
    """ "all", or names with commas between them, in the order given; None means the estimator's default."""
    known = known_methods()
    if text is None:
        return [str(field_descriptions()[METHOD_KEY].default)]
    names = [name.strip() for name in text.split(",") if name.strip()]
    if names == [ALL]:
        return list(known)
    if not names:
        raise UserError(f"--methods: names no method; give {ALL} or some of {', '.join(known)}")
    for name in names:
        if name not in known:
            raise UserError(f"--methods: '{name}' is no method{nearest_hint(name, known)}; the known ones are {', '.join(known)}")
        if names.count(name) > 1:
            raise UserError(f"--methods: '{name}' appears twice; name each method once")
    return names
