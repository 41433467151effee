"""Reading from zip archives within bounds: a small file must not unfold into a huge one, and a cut one says so."""

import zipfile
import zlib
from pathlib import Path

from ssjs_cli.errors import UserError


def check_archive_size(archive_path: Path, max_bytes: int) -> None:
    """Refuses an archive whose members together claim more than max_bytes. Raises zipfile.BadZipFile for what is no archive."""
    with zipfile.ZipFile(archive_path) as archive:
        claimed = sum(member.file_size for member in archive.infolist())
    if claimed > max_bytes:
        raise UserError(f"{archive_path}: unfolds to {claimed} bytes, more than the {max_bytes} allowed; give a smaller archive")


def read_member(archive_path: Path, name: str, max_bytes: int) -> bytes:
    """One member, by its file name in any folder of the archive."""
    try:
        with zipfile.ZipFile(archive_path) as archive:
            members = [member for member in archive.infolist() if member.filename.rsplit("/", 1)[-1].lower() == name.lower()]
            if not members:
                held = ", ".join(sorted(member.filename for member in archive.infolist())[:8])
                raise UserError(f"{archive_path}: holds no {name} (it holds {held}); give the archive of the data set")
            if members[0].file_size > max_bytes:
                raise _too_large(archive_path, name, max_bytes)
            with archive.open(members[0]) as file:
                data = file.read(max_bytes + 1)
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError) as error:
        raise UserError(f"{archive_path}: is damaged or cut short, {name} cannot be read ({error}); fetch the archive again") from error
    if len(data) > max_bytes:
        raise _too_large(archive_path, name, max_bytes)
    return data


def _too_large(archive_path: Path, name: str, max_bytes: int) -> UserError:
    return UserError(f"{archive_path}: {name} unfolds to more than the {max_bytes} bytes allowed; give the archive of the data set")
