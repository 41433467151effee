"""One colour a method, the same in every report whatever else is compared."""

from ssjs_cli.report.submap_colours import PALETTE


def method_colours(methods: list[str], known: tuple[str, ...]) -> dict[str, str]:
    """By the place of a method in the list of all; a method that is not in it comes after them."""
    places = [*known, *(method for method in methods if method not in known)]
    return {method: PALETTE[places.index(method) % len(PALETTE)] for method in methods}
