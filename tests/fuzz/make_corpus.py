"""Seeds of the fuzzers: small inputs of every kind that each parser knows, a folder a fuzzer.

python make_corpus.py FOLDER
"""

import sys
from pathlib import Path

import cascade_seeds
import log_seeds
import stream_seeds


def main() -> int:
    if len(sys.argv) != 2:
        print("usage: make_corpus.py FOLDER", file=sys.stderr)
        return 2
    fuzzers = {
        "sonar_log": log_seeds.sonar_log(),
        "cascade_json": cascade_seeds.json_models(),
        "cascade_xml": cascade_seeds.xml_models(),
        "settings": stream_seeds.settings(),
        "log_columns": stream_seeds.log_columns(),
        "online": stream_seeds.online(),
        "checkpoint": stream_seeds.checkpoint_edits(),
    }
    for name, seeds in fuzzers.items():
        folder = Path(sys.argv[1]) / name
        folder.mkdir(parents=True, exist_ok=True)
        for number, seed in enumerate(seeds):
            (folder / f"seed_{number}").write_bytes(seed)
    return 0


if __name__ == "__main__":
    sys.exit(main())
