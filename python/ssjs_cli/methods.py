"""The methods for a kind of mission: those that the estimator lists, never a list of our own."""

from ssjs_cli.config import ESTIMATOR, METHOD_KEY, UNDERWATER, SettingsKind, field_descriptions
from ssjs_cli.errors import UserError, nearest_hint

ALL = "all"


def known_methods() -> tuple[str, ...]:
    """Of every kind of mission, each once."""
    return tuple(dict.fromkeys(method for kind in (ESTIMATOR, UNDERWATER) for method in methods_of(kind)))


def methods_of(kind: SettingsKind) -> tuple[str, ...]:
    return field_descriptions(kind)[METHOD_KEY].choices


def chosen_methods(text: str | None, kind: SettingsKind = ESTIMATOR) -> list[str]:
    """ "all" that are defined for such missions, or names with commas between them, in the order given; None means the estimator's
    default."""
    known = methods_of(kind)
    if text is None:
        return [str(field_descriptions(kind)[METHOD_KEY].default)]
    names = [name.strip() for name in text.split(",") if name.strip()]
    if names == [ALL]:
        return list(known)
    if not names:
        raise UserError(f"--methods: names no method; give {ALL} or some of {', '.join(known)}")
    for name in names:
        if name not in known:
            refuse_elsewhere(name, kind, "--methods")
            raise UserError(f"--methods: '{name}' is no method{nearest_hint(name, known)}; the known ones are {', '.join(known)}")
        if names.count(name) > 1:
            raise UserError(f"--methods: '{name}' appears twice; name each method once")
    return names


def refuse_elsewhere(name: str, kind: SettingsKind, source: str) -> None:
    """A method that is defined for the other kind of mission alone, with the reason. docs/math/underwater_methods.md (U-6)"""
    known = methods_of(kind)
    if name in known or name not in known_methods():
        return
    if kind is UNDERWATER:
        where = (
            "is defined for odometry in the plane and range and bearing of landmarks, not under water (where ekf is the filter of one map)"
        )
    else:
        where = "is for underwater missions"
    raise UserError(f"{source}: '{name}' {where}; the methods here are {', '.join(known)}")
