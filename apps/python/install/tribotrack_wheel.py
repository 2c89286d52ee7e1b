"""Builds the wheel for `pip install ./apps/python` (PEP 517): CMake makes the module and the program, this packs them.

The quickstart's build is used where it is for this Python, else build/python-VERSION.
"""

import base64
import hashlib
import os
import re
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
MODULE = "_core" + sysconfig.get_config_var("EXT_SUFFIX")
METADATA = """Metadata-Version: 2.1
Name: tribotrack
Version: {version}
Summary: From high-speed video of a part on a vibrating platform to its friction parameters
License: BSD-3-Clause
Requires-Python: >={python}
Provides-Extra: all
Requires-Dist: numpy; extra == "all"
Requires-Dist: matplotlib; extra == "all"
Requires-Dist: pandas; extra == "all"
"""
WHEEL = "Wheel-Version: 1.0\nGenerator: tribotrack\nRoot-Is-Purelib: false\nTag: {tag}\n"


def _built():
    """The folder of a build with the module for this Python."""
    folder = ROOT / "build/release"
    if not (folder / "apps/python/tribotrack" / MODULE).exists():
        folder = ROOT / f"build/python-{sysconfig.get_python_version()}"
        if not (folder / "build.ninja").exists():
            _run("cmake", "-S", ROOT, "-B", folder, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DTRIBOTRACK_TESTS=OFF",
                 f"-DPython3_EXECUTABLE={sys.executable}")
    _run("cmake", "--build", folder, "--target", "tribotrack", "tribotrack_python")
    if not (folder / "apps/python/tribotrack" / MODULE).exists():
        raise SystemExit(f"no module for {sys.executable}: install python3-dev and pybind11-dev (apps/install/install_packages.sh build)")
    return folder


def _run(*command):
    subprocess.run([*map(str, command)], check=True)


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    version = re.search(r"project\(tribotrack VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text()).group(1)
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    tag = f"{python}-{python}-{re.sub('[-.]', '_', sysconfig.get_platform())}"
    folder, info = _built() / "apps", f"tribotrack-{version}.dist-info"
    files = {f"tribotrack/{file.name}": file for file in (ROOT / "apps/python/tribotrack").iterdir() if file.is_file()}
    files[f"tribotrack/{MODULE}"] = folder / "python/tribotrack" / MODULE
    files[f"tribotrack-{version}.data/scripts/tribotrack"] = folder / "tribotrack"
    files[f"{info}/LICENSE"] = ROOT / "LICENSE"
    contents = {name: file.read_bytes() for name, file in sorted(files.items())}
    contents[f"{info}/METADATA"] = METADATA.format(version=version, python=sysconfig.get_python_version()).encode()
    contents[f"{info}/WHEEL"] = WHEEL.format(tag=tag).encode()
    record = ""
    name = f"tribotrack-{version}-{tag}.whl"
    with zipfile.ZipFile(os.path.join(wheel_directory, name), "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, data in contents.items():
            _add(wheel, path, data)
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            record += f"{path},sha256={digest},{len(data)}\n"
        _add(wheel, f"{info}/RECORD", (record + f"{info}/RECORD,,\n").encode())
    return name


def _add(wheel, path, data):
    """Readable, and the program executable."""
    entry = zipfile.ZipInfo(path)
    entry.external_attr = (0o100755 if "/scripts/" in path else 0o100644) << 16
    entry.compress_type = zipfile.ZIP_DEFLATED
    wheel.writestr(entry, data)
