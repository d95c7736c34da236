#!/usr/bin/env python3
"""archive_test.py SOURCE BUILD [FOLDER PART...]: packs what BUILD has made (cmake/package/package.sh), twice, and uses the archives as somebody
does who has nothing else: the repository is hidden, the environment empty, the folder new.

 - two runs give the same bytes; the library needs the C library alone, the tool what it brings along and the C++ runtime
 - every command of docs/quickstart.md, with what it prints: a struct of 20 members, green and red
 - the game of README.md by pkg-config and by find_package, shared and static: green, and red with tick, column, row, values
 - the package for Debian: fields, installation, removal
 - the workflows docs/ci.yml and docs/ci_engine.yml: every step that they run

PARTs (archives, quickstart, readme, debian, workflows) run alone, with the archives that are in FOLDER or are made there.
TICKTRUE_UPDATE_DOCS=1 writes the outputs of docs/quickstart.md anew. Exit 77 where BUILD has no target ticktrue_packaged.
SPDX-License-Identifier: MIT
"""
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile

SOURCE = pathlib.Path(sys.argv[1]).resolve()
BUILD = pathlib.Path(sys.argv[2]).resolve()
VERSION = re.search(r"project\(ticktrue VERSION (\S+)", (SOURCE / "CMakeLists.txt").read_text()).group(1)
LINUX = f"ticktrue-{VERSION}-linux-x86_64"
DEBIAN = f"ticktrue_{VERSION}-1_amd64.deb"
WINDOWS = f"ticktrue-{VERSION}-windows-x86_64"
failures = []


def check(holds, message):
    if not holds:
        failures.append(message)
        print(f"package: error: {message}", flush=True)
    return holds


def run(words, **options):
    return subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, **options)


def can_hide():
    return os.geteuid() == 0 and run(["unshare", "-m", "true"]).returncode == 0


class Room:
    """A folder in which commands run without the repository and without the environment of this process."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)
        self.settings = {"HOME": str(self.folder), "PATH": "/usr/local/bin:/usr/bin:/bin", "LC_ALL": "C.UTF-8"}

    def run(self, command):
        hide = "".join(f"mount -t tmpfs none '{place}' && " for place in (SOURCE, BUILD) if place.is_dir())
        line = f"cd '{self.folder}' && {{ {command}\n}} </dev/null"
        words = ["env", "-i"] + [f"{name}={value}" for name, value in self.settings.items()]
        if can_hide():
            inner = " ".join("'" + word + "'" for word in words)
            # The second place is inside the first, and is removed with it, unless it is elsewhere.
            hide = hide.replace(f"mount -t tmpfs none '{BUILD}' && ", "") if BUILD.is_relative_to(SOURCE) else hide
            return run(["unshare", "-m", "sh", "-c", f'{hide}exec {inner} sh -c "$1"', "sh", line])
        return run(words + ["sh", "-c", line])


def lines_are_there(shown, found):
    """The first shown line that is not in its place, or None. A line "..." stands for any number of lines."""
    at, may_skip = 0, False
    for line in (without_chance(line) for line in shown):
        if line.strip() == "...":
            may_skip = True
            continue
        while at < len(found) and may_skip and without_chance(found[at]) != line:
            at += 1
        if at == len(found) or without_chance(found[at]) != line:
            return line
        at, may_skip = at + 1, False
    return None if may_skip or at == len(found) else f"an end; found {found[at]}"


def without_chance(line):
    line = re.sub(r"ticktrue \d[0-9.]* \(.*", "ticktrue #", line)
    line = re.sub(r"(gcc [0-9.]+|build id [0-9a-f]+)", "#", line)
    return re.sub(r"(\d+\.\d+ )sec", "# sec", line).rstrip()


# --- the archives -----------------------------------------------------------------------------------------------------
def pack(out, windows):
    done = run([str(SOURCE / "cmake/package/package.sh"), "--build", str(BUILD), "--out", str(out), "--windows", str(windows)],
               env=os.environ | {"PACKAGE_LEVEL": "1"})
    check(done.returncode == 0, f"package.sh: exit code {done.returncode}\n{done.stdout}")
    return sorted(path.name for path in out.iterdir())


def make_archives(work):
    tree = work / "windows_tree"
    for name in ("bin/libticktrue.dll", "lib/libticktrue.dll.a", "include/ticktrue.h"):
        (tree / name).parent.mkdir(parents=True, exist_ok=True)
        (tree / name).write_text("a stand-in\n")
    names = pack(work / "first", tree)
    wanted = sorted(["SHA256SUMS", f"{LINUX}.tar.gz", f"ticktrue-{VERSION}.tar.gz", f"{WINDOWS}.zip", DEBIAN])
    check(names == wanted, f"archives: found {names}, expected {wanted}")


def check_archives(work):
    pack(work / "second", work / "windows_tree")
    sums = dict(reversed(line.split()) for line in (work / "first/SHA256SUMS").read_text().splitlines())
    check(len(sums) == 4, f"SHA256SUMS: lines: found {len(sums)}, expected 4")
    for name in sums:
        first, second = ((work / run_name / name).read_bytes() for run_name in ("first", "second"))
        check(first == second, f"{name}: the second run gave other bytes")
        check(sums[name] == hashlib.sha256(first).hexdigest(), f"SHA256SUMS: {name}: another checksum")
    for name in (f"{LINUX}.tar.gz", f"ticktrue-{VERSION}.tar.gz"):
        with tarfile.open(work / "first" / name) as archive:
            members = archive.getmembers()
            check(len({member.mtime for member in members}) == 1, f"{name}: times: expected that of the commit alone")
            check(all(member.uid == member.gid == 0 for member in members), f"{name}: owner: expected 0 alone")
            check(len({member.name.split("/")[0] for member in members}) == 1, f"{name}: expected one folder")
    with zipfile.ZipFile(work / "first" / f"{WINDOWS}.zip") as archive:
        check(f"{WINDOWS}/bin/libticktrue.dll" in archive.namelist(), "zip: found no library")


def check_programs(tree):
    """What the programs ask for: the C library alone, and no folder of this machine. The tool also asks for the C++
    runtime and for libraries that it brings along."""
    brought = {path.name for path in (tree / "lib/ticktrue").iterdir()}
    check(len(brought) == 4, f"lib/ticktrue: found {sorted(brought)}, expected four libraries")
    runtime = {"libc.so.6", "libm.so.6", "ld-linux-x86-64.so.2"}
    of_cpp = runtime | {"libstdc++.so.6", "libgcc_s.so.1"}
    allowed = {"bin/ticktrue": of_cpp | brought, f"lib/libticktrue.so.{VERSION}": runtime, "lib/libticktrue_shim.so": runtime}
    allowed |= {f"lib/ticktrue/{name}": of_cpp | brought for name in brought}
    for name, libraries in allowed.items():
        dynamic = run(["objdump", "-p", str(tree / name)]).stdout
        needed = set(re.findall(r"NEEDED +(\S+)", dynamic))
        check(needed and needed <= libraries, f"{name}: needs {sorted(needed)}")
        paths = re.findall(r"R(?:UN)?PATH +(\S+)", dynamic)
        expected = ["$ORIGIN/../lib/ticktrue"] if name == "bin/ticktrue" else []
        check(paths == expected, f"{name}: paths of libraries: found {paths}, expected {expected}")
    # Unique symbols ("u") stay visible even after objcopy, because the linker merges them.
    names = run(["nm", "--defined-only", "--extern-only", "--format=posix", str(tree / "lib/libticktrue.a")]).stdout
    symbols = [line.split()[:2] for line in names.splitlines() if len(line.split()) >= 2]
    check(len(symbols) > 50, f"libticktrue.a: names: found {len(symbols)}")
    others = [name for name, kind in symbols if kind != "u" and not name.startswith("ticktrue_")]
    check(not others, f"libticktrue.a: shows {others[:3]}, expected ticktrue_* alone")
    for name in ("LICENSE", "QUICKSTART.md", "licences/README", "licences/libbox2d-dev", "licences/LGPL-3", "docs/ci.yml",
                 "examples/lockstep.c", "include/ticktrue.hpp", "include/ticktrue/math.h"):
        check((tree / name).is_file(), f"archive: found no {name}")
    for path in list((tree / "lib").rglob("*.cmake")) + list((tree / "lib").rglob("*.pc")):
        text = path.read_text()
        check(str(SOURCE) not in text and str(BUILD) not in text and "zstd" not in text, f"{path.name}: names this machine")
    for link in re.findall(r"\]\(([^):#]*)", (tree / "QUICKSTART.md").read_text()):
        check((tree / link).is_file(), f"QUICKSTART.md: the link {link} leads to no file")


# --- docs/quickstart.md -----------------------------------------------------------------------------------------------
def check_quickstart(work):
    path = SOURCE / "docs/quickstart.md"
    lines = path.read_text().splitlines()
    room = Room(work / "quickstart")
    for name in (f"{LINUX}.tar.gz", "SHA256SUMS"):
        shutil.copy(work / "first" / name, room.folder)
    written, at, count = [], 0, 0
    while at < len(lines):
        written.append(lines[at])
        if not lines[at].startswith("```"):
            at += 1
            continue
        end = lines.index("```", at + 1)
        block, title = lines[at + 1:end], lines[at][3:].split()
        if len(title) == 2:
            (room.folder / title[1]).write_text("\n".join(block) + "\n")
            written += block
        else:
            count += run_block(room, block, written)
        written.append("```")
        at = end + 1
    check(count >= 15, f"quickstart.md: found {count} commands, expected 15 or more")
    # The struct has 20 or more members of 8 types, and a column for each.
    struct = re.search(r"struct Unit \{(.*?)\n\};", path.read_text(), re.S).group(1)
    members = re.findall(r"[\w:]+(?:, \w+)*;", re.sub(r"^\s*[\w:]+ ", "", struct, flags=re.M))
    names = [name for member in members for name in member.rstrip(";").split(", ")]
    check(len(names) == 20 and struct.count(";") >= 8, f"quickstart.md: members: found {len(names)}, expected 20")
    line = re.search(r"TICKTRUE_COLUMNS\(Unit, (.*?)\)", (room.folder / "columns.inc").read_text(), re.S)
    check(line and re.split(r",\s*", line.group(1)) == names, f"columns.inc: columns: expected {names}")
    if os.environ.get("TICKTRUE_UPDATE_DOCS"):
        path.write_text("\n".join(written) + "\n")


def run_block(room, block, written):
    """Commands behind "$ " with what they print; returns how many."""
    commands = [number for number, line in enumerate(block) if line.startswith("$ ")]
    for number, begin in enumerate(commands):
        end = commands[number + 1] if number + 1 < len(commands) else len(block)
        command, shown = block[begin][2:], block[begin + 1:end]
        if setting := re.fullmatch(r"export (\w+)=(\S+)", command):
            value = setting.group(2).replace("$PWD", str(room.folder)).replace("$PATH", room.settings["PATH"])
            room.settings[setting.group(1)] = value
            written.append(block[begin])
            continue
        done = room.run(command)
        found = done.stdout.splitlines()
        wanted = 1 if shown and shown[0].startswith("diverged") else 0
        check(done.returncode == wanted, f"{command}: exit code: found {done.returncode}, expected {wanted}\n{done.stdout}")
        missing = lines_are_there(shown, found)
        if missing is not None and os.environ.get("TICKTRUE_UPDATE_DOCS") and "..." not in shown:
            shown = found
        else:
            check(missing is None, f"{command}: expected {missing}\n{done.stdout}")
        written += [block[begin]] + shown
    return len(commands)


# --- the game of README.md --------------------------------------------------------------------------------------------
def check_readme_game(work, tree):
    text = (SOURCE / "README.md").read_text()
    game = text.split("```cpp\n", 1)[1].split("```", 1)[0]
    room = Room(work / "readme game")
    shutil.copytree(tree, room.folder / "ticktrue", symlinks=True)
    (room.folder / "mygame.cpp").write_text(game)
    (room.folder / "CMakeLists.txt").write_text("""cmake_minimum_required(VERSION 3.16)
project(mygame LANGUAGES CXX)
set(CMAKE_CXX_STANDARD 20)
find_package(ticktrue 0.2 REQUIRED)
foreach(kind ticktrue ticktrue_static)
  add_executable(by_${kind} mygame.cpp)
  target_link_libraries(by_${kind} PRIVATE ticktrue::${kind})
endforeach()
""")
    packages = "PKG_CONFIG_PATH=ticktrue/lib/pkgconfig pkg-config --cflags --libs"
    builds = {
        "./by_pkg_config": f'c++ -std=c++20 -O2 mygame.cpp $({packages} ticktrue) "-Wl,-rpath,$PWD/ticktrue/lib" -o by_pkg_config',
        "./by_static": f"c++ -std=c++20 -O2 mygame.cpp $({packages} ticktrue-static) -o by_static",
        "build/by_ticktrue": 'cmake -S . -B build -DCMAKE_BUILD_TYPE=Release "-DCMAKE_PREFIX_PATH=$PWD/ticktrue" && cmake --build build',
        "build/by_ticktrue_static": "true",
    }
    for program, command in builds.items():
        done = room.run(command)
        check(done.returncode == 0, f"README's game: {command}\n{done.stdout}")
        trace = program.replace("/", "_") + ".ttr"
        done = room.run(f"{program} --record {trace} --detail full")
        check("recorded" in done.stdout and "600 ticks" in done.stdout, f"{program} --record\n{done.stdout}")
        done = room.run(f"{program} --verify {trace}")
        check(done.returncode == 0 and "600 of 600 ticks compared" in done.stdout, f"{program} --verify\n{done.stdout}")
    # Another game: the unit bounces in another way.
    (room.folder / "mygame.cpp").write_text(game.replace("u.vy *= -0.8f", "u.vy *= -0.75f"))
    for program in ("./by_pkg_config", "build/by_ticktrue"):
        room.run(builds[program] if program == "./by_pkg_config" else "cmake --build build --target by_ticktrue")
        done = room.run(f"{program} --verify {program.replace('/', '_')}.ttr")
        check(done.returncode == 1, f"{program}, changed: exit code: found {done.returncode}, expected 1")
        place = re.search(r"tick 46 of 600.*column  units\.vy +row 0 \(id 0\).*expected \w+ \([-0-9.]+\)\.  got \w+ \(", done.stdout, re.S)
        check(place, f"{program}, changed: expected tick, column, row and values, found\n{done.stdout}")


# --- the package for Debian -------------------------------------------------------------------------------------------
def check_debian_package(work):
    package = work / "first" / DEBIAN
    fields = run(["dpkg-deb", "--field", str(package)]).stdout
    for field in (f"Version: {VERSION}-1", "Architecture: amd64", "Section: devel", "Maintainer: ", "Installed-Size: ",
                  "Description: "):
        check(f"\n{field}" in f"\n{fields}", f"{DEBIAN}: fields: expected {field}\n{fields}")
    check(re.search(r"^Depends: libc6 \(>= 2\.\d+\), libgcc-s1, libstdc\+\+6 \(>= 12\)$", fields, re.M),
          f"{DEBIAN}: Depends: expected the C library and the C++ runtime alone\n{fields}")
    for line in run(["dpkg-deb", "--contents", str(package)]).stdout.splitlines():
        check(" root/root " in line and re.match(r"[d-]r.xr-xr-x |-rw-r--r-- |l", line), f"{DEBIAN}: {line}")
    root = work / "root"
    for folder in ("var/lib/dpkg/info", "var/lib/dpkg/updates", "var/lib/dpkg/triggers"):
        (root / folder).mkdir(parents=True)
    (root / "var/lib/dpkg/status").touch()
    dpkg = ["dpkg", f"--root={root}", "--force-depends", "--force-not-root", "--force-script-chrootless", "--log=/dev/null"]
    done = run(dpkg + ["--install", str(package)])
    check(done.returncode == 0, f"dpkg --install\n{done.stdout}")
    done = run([str(root / "usr/bin/ticktrue"), "--version"])
    check(done.returncode == 0 and VERSION in done.stdout, f"ticktrue --version\n{done.stdout}")
    done = run(dpkg + ["--verify", "ticktrue"])
    check(done.returncode == 0 and not done.stdout, f"dpkg --verify\n{done.stdout}")
    text = (root / "usr/lib/pkgconfig/ticktrue.pc").read_text()
    check("prefix=/usr\n" in text, f"ticktrue.pc: expected prefix=/usr\n{text}")
    done = run(dpkg + ["--purge", "ticktrue"])
    left = [str(path) for path in (root / "usr").rglob("*")] if (root / "usr").exists() else []
    check(done.returncode == 0 and not left, f"dpkg --purge: left {left[:3]}\n{done.stdout}")


# --- the workflows ----------------------------------------------------------------------------------------------------
def steps_of(path):
    """The `run` steps of a workflow's jobs, in their order, and its `env`."""
    text = path.read_text()
    settings = dict(re.findall(r"^  ([A-Z_0-9]+): (\S+)", text, re.M))
    jobs, job = {}, None
    for line in text.splitlines():
        if found := re.fullmatch(r"  (\w+):", line):
            job = jobs.setdefault(found.group(1), {"steps": [], "matrix": {}})
        elif found := re.fullmatch(r" {8}(\w+): \[(.*)\]", line):
            job["matrix"][found.group(1)] = found.group(2).split(", ")
        elif found := re.fullmatch(r" {6}- run: (.*)", line):
            job["steps"].append(found.group(1))
    return settings, jobs


def run_job(name, room, settings, job, values, last_exit):
    """The steps of one job on a fresh checkout; the last one ends with that exit code."""
    room.settings |= settings
    for number, step in enumerate(job["steps"]):
        if step.startswith("sudo apt-get"):
            continue  # the packages are already installed
        for key, value in values.items():
            step = step.replace("${{ matrix.%s }}" % key, value)
        check("${{" not in step, f"{name}: a value that the test does not know: {step}")
        done = room.run(step)
        wanted = last_exit if number + 1 == len(job["steps"]) else 0
        if not check(done.returncode == wanted, f"{name}: {step}: exit code: found {done.returncode}, expected {wanted}\n{done.stdout}"):
            return ""
    return done.stdout


def checkout(folder, files):
    room = Room(folder)
    for name, origin in files.items():
        (room.folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(origin, room.folder / name)
    return room


def check_workflows(work, tree):
    archive = work / "first" / f"{LINUX}.tar.gz"
    for name in ("ci.yml", "ci_engine.yml"):
        settings, jobs = steps_of(SOURCE / "docs" / name)
        check(set(settings) == {"ARCHIVE", "SHA256"}, f"{name}: env: found {sorted(settings)}")
        settings = {"ARCHIVE": archive.as_uri(), "SHA256": hashlib.sha256(archive.read_bytes()).hexdigest()}
        files = files_of_game(work) if name == "ci.yml" else files_of_engine(work, tree)
        for job_name, job in jobs.items():
            check(len(job["steps"]) >= 4, f"{name}: {job_name}: steps: found {len(job['steps'])}, expected 4 or more")
            check("always()" in (SOURCE / "docs" / name).read_text(), f"{name}: results are kept only if all is green")
            matrix = [{}] + [{key: value} for key, values in job["matrix"].items() for value in values]
            for values in matrix[1:] if len(matrix) > 1 else matrix:
                if shutil.which(values.get("compiler", "sh")) is None:
                    print(f"package: note: no {values['compiler']} here")
                    continue
                place = f"{name}: {job_name} {values}"
                room = checkout(work / "ci" / re.sub(r"\W+", "_", place), files)
                run_job(place, room, settings, job, values, 0)
                if (room.folder / "results.xml").exists():
                    check("<testsuite" in (room.folder / "results.xml").read_text(), f"{place}: results.xml")
        # Red: the same repository after a change of behaviour.
        job_name, job = next(iter(jobs.items()))
        values = {key: values[0] for key, values in job["matrix"].items()}
        room = checkout(work / "ci" / f"{name} red", files)
        change(room.folder / ("units.h" if name == "ci.yml" else "engine_plugin.c"))
        out = run_job(f"{name}, red", room, settings, job, values, 1)
        check("::error file=traces/" in out, f"{name}, red: expected an annotation\n{out}")
        for result in ("results.xml", "failure.html"):
            check((room.folder / result).is_file(), f"{name}, red: found no {result}")
        check("<failure" in (room.folder / "results.xml").read_text(), f"{name}, red: results.xml: found no failure")
        wrong = Room(work / "ci" / f"{name} wrong")
        step = next(step for step in job["steps"] if "sha256sum" in step)
        wrong.settings |= settings | {"SHA256": "0" * 64}
        check(wrong.run(step).returncode != 0, f"{name}: an archive with another checksum is taken")


def change(path):
    text = path.read_text()
    other = text.replace("*= -0.8f", "*= -0.75f").replace("-9.8125", "-9.75")
    check(text != other, f"{path.name}: found nothing to change")
    path.write_text(other)


def files_of_game(work):
    """What a reader of docs/quickstart.md has in the end."""
    folder = work / "quickstart"
    return {"units.h": folder / "units.h", "game.cpp": folder / "game.cpp", "columns.inc": folder / "columns.inc",
            "traces/session_1.ttr": folder / "game.ttr"}


def files_of_engine(work, tree):
    """A plug-in, its golden trace and the manifest, made as docs/ci.md says."""
    room = Room(work / "engine")
    shutil.copy(tree / "examples/plugin_pendulum.c", room.folder / "engine_plugin.c")
    room.settings["PATH"] = f"{tree}/bin:" + room.settings["PATH"]
    adding = re.search(r"^ticktrue golden add .*$", (SOURCE / "docs/ci.md").read_text(), re.M).group(0)
    for command in (f"cc -O2 -ffp-contract=off -fPIC -shared '-I{tree}/include' engine_plugin.c -o engine.so && mkdir traces", adding):
        done = room.run(command)
        check(done.returncode == 0, f"{command}\n{done.stdout}")
    return {"engine_plugin.c": room.folder / "engine_plugin.c"} | {
        f"traces/{path.name}": path for path in (room.folder / "traces").iterdir()}


def main():
    if not (BUILD / "packaged/libticktrue.a").is_file() or not (BUILD / "packaged/ticktrue").is_file():
        print(f"package: skipped: cmake --build {BUILD} --target ticktrue_packaged")
        return 77
    work = pathlib.Path(sys.argv[3] if len(sys.argv) > 3 else tempfile.mkdtemp(prefix="ticktrue_package_")).resolve()
    parts = sys.argv[4:] or ["archives", "quickstart", "readme", "debian", "workflows"]
    try:
        if not (work / "first").is_dir():
            make_archives(work)
        if not (work / "unpacked").is_dir():
            with tarfile.open(work / "first" / f"{LINUX}.tar.gz") as archive:
                archive.extractall(work / "unpacked")
        tree = work / "unpacked" / LINUX
        check_programs(tree)
        for part in parts:
            if part == "archives":
                check_archives(work)
            elif part == "quickstart":
                check_quickstart(work)
            elif part == "readme":
                check_readme_game(work, tree)
            elif part == "debian":
                check_debian_package(work)
            elif part == "workflows":
                check_workflows(work, tree)
            else:
                check(False, f"unknown part: {part}")
    finally:
        if len(sys.argv) <= 3:
            shutil.rmtree(work)
    print(f"package: {'the repository was hidden' if can_hide() else 'not root: the repository was not hidden'}")
    print("package: packed twice, used from nothing" if not failures else f"package: {len(failures)} errors")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
