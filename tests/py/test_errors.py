import errno

from ssjs_cli.errors import describe_os_error, nearest_hint


def test_nearest_hint_names_the_most_similar_key() -> None:
    assert nearest_hint("sensor.rang_sigma_m", ["sensor.range_sigma_m", "trees.max_range_m"]) == " (did you mean 'sensor.range_sigma_m'?)"


def test_nearest_hint_falls_back_to_the_last_component() -> None:
    assert nearest_hint("wheelbase", ["vehicle.ackerman.wheelbase_m", "method"]) == " (did you mean 'vehicle.ackerman.wheelbase_m'?)"


def test_nearest_hint_is_silent_when_nothing_resembles() -> None:
    assert nearest_hint("xyzzy", ["sensor.range_sigma_m"]) == ""


def test_a_full_disk_names_the_path_and_the_mend() -> None:
    text = describe_os_error(OSError(errno.ENOSPC, "No space left on device"), "runs/a")
    assert text == "runs/a: No space left on device; free some space on that disk or choose another --out"


def test_the_errors_own_path_is_named_when_none_is_given() -> None:
    assert describe_os_error(PermissionError(errno.EACCES, "x", "a.csv")).startswith("a.csv: Permission denied; ")
