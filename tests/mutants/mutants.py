#!/usr/bin/env python3
"""Mutants: changes single tokens of the source, one at a time, and runs a check that should notice.

A line of code is drawn uniformly, then one of its tokens, then one of the token's replacements. The mutant is built in a
copy of the tree. A mutant is killed if the check fails, crashes or does not end in time.
"""
# SPDX-License-Identifier: MIT
import argparse
import collections
import concurrent.futures
import glob
import hashlib
import itertools
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import threading
import time

# Files whose structures outlive a tick, or that put constraints into batches.
CACHE_FILES = """
engine/broad_phase/aabb_tree.cpp engine/broad_phase/aabb_tree.h engine/broad_phase/box_tree.cpp
engine/broad_phase/box_tree.h engine/broad_phase/neighbour_cells.cpp engine/broad_phase/pair_list.cpp
engine/broad_phase/pair_list.h engine/broad_phase/pair_listing.h engine/broad_phase/proxy_boxes.cpp
engine/broad_phase/proxy_boxes.h engine/broad_phase/sort_pairs.cpp engine/narrow_phase/narrow_phase.cpp
engine/narrow_phase/contact_caches.h engine/narrow_phase/pair_block.h engine/narrow_phase/box_pairs.cpp
engine/narrow_phase/box_pairs.h engine/contacts/contact_batch.cpp engine/contacts/contact_blocks.cpp
engine/contacts/contact_coloring.cpp engine/contacts/contact_coloring.h engine/contacts/contact_filling.cpp
engine/contacts/island_blocks.cpp engine/contacts/island_blocks.h engine/islands/solver_sets.cpp
engine/joints/joint_order.cpp engine/joints/joint_plan.cpp engine/joints/joint_plan.h
engine/joints/batched/driven_revolute_batch.cpp engine/joints/batched/level_schedule.cpp
engine/joints/batched/revolute_batch.cpp engine/joints/batched/wavefront.cpp engine/model/bodies.cpp
engine/model/bodies.h engine/integrators/flow.cpp engine/integrators/motion_rows.h engine/model/motion_bounds.cpp
engine/model/motion_bounds.h engine/model/margins.h engine/solvers/substep_strategies.cpp
""".split()

# Files that decide a verdict: they walk over ticks, compare them, name differences, and choose an exit code.
VERDICT_FILES = """
verifier/verify/*.cpp verifier/verify/*.h verifier/locate/*.cpp verifier/locate/*.h verifier/report/exit_codes.cpp
verifier/report/exit_codes.h
""".split()

# Files whose results are physics.
PHYSICS_FILES = """
engine/solvers/*.cpp engine/solvers/*.h engine/joints/**/*.cpp engine/joints/**/*.h engine/integrators/*.cpp
engine/integrators/*.h
""".split()

ALL_FILES = """
replay/**/*.cpp replay/**/*.h verifier/**/*.cpp verifier/**/*.h engine/**/*.cpp engine/**/*.h
""".split()

SOAK = ("'{program}' soak --worlds 1000000 --seed {seed} --time {time} --failures 1 -j {threads} "
        "--hashes '{root}/tests/worlds/hashes.tsv' --cache-counts '{root}/tests/worlds/cache_counts.tsv' --out '{out}'")
# Quick tests first, because the first failure ends the check.
# No golden trace: studies alone.
STUDIES = "'{root}/tests/mutants/run_studies.sh' '{program}' {time}"
TESTS = "'{root}/tests/mutants/run_tests.sh' '{build}' {time}"

Set = collections.namedtuple('Set', 'files has_tests check word grace has_effect')
SETS = {
    'caches': Set(CACHE_FILES, False, SOAK, 'found', 120, False),
    'verdicts': Set(VERDICT_FILES, True, TESTS, 'failed:', 3000, False),
    'all': Set(ALL_FILES, True, TESTS, 'failed:', 3000, False),
    'physics': Set(PHYSICS_FILES, False, STUDIES, 'failed:', 3000, True),
}

REPLACEMENTS = {
    '==': ['!='], '!=': ['=='], '<=': ['<', '>'], '>=': ['>', '<'], ' < ': [' <= ', ' > '], ' > ': [' >= ', ' < '],
    '&&': ['||'], '||': ['&&'], ' + ': [' - '], ' - ': [' + '], ' * ': [' + '], ' / ': [' * '], ' % ': [' / '],
    '+=': ['-='], '-=': ['+='], '|=': ['&=', '='], '&=': ['|=', '='], '++': ['--'], '--': ['++'],
    ' & ': [' | '], ' | ': [' & '], ' >> ': [' << '], ' << ': [' >> '],
    'true': ['false'], 'false': ['true'], 'continue': ['break'], '!': [''],
    'first': ['second'], 'second': ['first'], 'begin': ['end'], 'end': ['begin'], 'lower': ['upper'],
    'upper': ['lower'], 'smaller': ['larger'], 'larger': ['smaller'], 'body_a': ['body_b'], 'body_b': ['body_a'],
    'contact_pairs': ['contact_pairs_merged'], 'row': ['row + 1'], 'count': ['count - 1'],
}
WORD = re.compile(r'[A-Za-z_]\w*|\d+')
OPERATORS = sorted((o for o in REPLACEMENTS if not WORD.fullmatch(o)), key=len, reverse=True)
SKIPPED = re.compile(r'^\s*(//|#|namespace|using|static_assert|template|TICKTRUE_ASSERT|\}|$)|\bfor_each_type\b|__builtin_prefetch')


def tokens_of(line):
    """(begin, end, replacement) of everything in a line that can be changed."""
    code = line.split('//')[0]
    code = re.sub(r'"[^"]*"', lambda m: '"' * len(m.group(0)), code)
    found = []
    for word in WORD.finditer(code):
        text = word.group(0)
        if text.isdigit():
            found += [(word.start(), word.end(), str(int(text) + 1))]
            if int(text) > 1:
                found += [(word.start(), word.end(), str(int(text) - 1))]
        else:
            found += [(word.start(), word.end(), other) for other in REPLACEMENTS.get(text, [])]
    at = 0
    while at < len(code):
        operator = next((o for o in OPERATORS if code.startswith(o, at)), None)
        if operator is None or (operator == '!' and code.startswith('!=', at)):
            at += 1
            continue
        found += [(at, at + len(operator), other) for other in REPLACEMENTS[operator]]
        at += len(operator)
    return found


def candidates_of(root, files):
    """(file, line number, line) of every line that has a token to change."""
    lines = []
    for name in (name for pattern in files for name in sorted(glob.glob(pattern, root_dir=root, recursive=True))):
        with open(os.path.join(root, name)) as source:
            for number, line in enumerate(source.read().split('\n')):
                if not SKIPPED.search(line) and tokens_of(line):
                    lines.append((name, number, line))
    return lines


def run(command, seconds, cwd=None):
    """(exit status or None after the time, output)"""
    child = subprocess.Popen(command, shell=True, cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                             start_new_session=True)
    try:
        output = child.communicate(timeout=seconds)[0]
        return child.returncode, output.decode(errors='replace')
    except subprocess.TimeoutExpired:
        os.killpg(child.pid, signal.SIGKILL)
        return None, child.communicate()[0].decode(errors='replace')


def digest(path):
    with open(path, 'rb') as data:
        return hashlib.sha256(data.read()).hexdigest()


def equivalents(path):
    """{(file, occurrence of the line in the file, line before, line after): why it cannot change a bit}"""
    if not path:
        return {}
    with open(path) as table:
        rows = [line.rstrip('\n').split('\t') for line in table][1:]
    return {tuple(row[:4]): row[4] for row in rows}


def key_of(mutant, lines):
    """What names a mutant, whatever stands above its line."""
    alike = [number for name, number, line in lines
             if name == mutant.name and line.strip() == mutant.before.strip()]
    return mutant.name, str(1 + alike.index(mutant.number)), mutant.before.strip(), mutant.after.strip()


class Workshop:
    """A copy of the tree with a build of its own: one mutant at a time."""

    def __init__(self, options, number):
        self.options = options
        self.out = os.path.join(options.out, str(number))
        self.tree = os.path.join(self.out, 'tree')
        self.build_dir = os.path.join(self.out, 'build')

    def prepare(self):
        shutil.rmtree(self.tree, ignore_errors=True)
        os.makedirs(self.tree)
        root = self.options.root
        subprocess.check_call(f"cd '{root}' && git ls-files -z | xargs -0 cp --parents -t '{self.tree}'", shell=True)
        # Without sed, a build has no digest of its sources: a mutant with equal code then gives an equal program. Tests
        # of stored verdicts need the digest.
        launcher = '-DCMAKE_CXX_COMPILER_LAUNCHER=ccache' if shutil.which('ccache') else ''
        # with tests, a header is in nearly every source: fewer units are quicker
        units = '-DTICKTRUE_UNITY=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=8 -DTICKTRUE_BUILD_TESTS=ON'
        parts = units if self.options.has_tests else '-DTICKTRUE_UNITY=OFF -DTICKTRUE_BUILD_TESTS=OFF'
        configure = (f"cmake -S '{self.tree}' -B '{self.build_dir}' -G Ninja -DCMAKE_BUILD_TYPE=Release "
                     f"-DCMAKE_CXX_FLAGS_RELEASE=-O2 -DCMAKE_CXX_FLAGS=-Wno-error -DTICKTRUE_BUILD_BENCH=OFF {parts} "
                     f"{'' if self.options.has_tests else '-DTICKTRUE_SED=OFF'} {launcher}")
        if self.options.has_tests:  # what is changed is compiled file by file, all else in units
            for folder in sorted({pattern.split('/')[0] for pattern in self.options.files}):
                lists = os.path.join(self.tree, folder, 'CMakeLists.txt')
                with open(lists) as file:
                    text = file.read()
                with open(lists, 'w') as file:
                    file.write('set(CMAKE_UNITY_BUILD OFF)\n' + text)
        for command in (configure, self.build_command(os.cpu_count())):
            status, output = run(command, 3600)
            if status != 0:
                sys.exit(f'mutants: error: {command}: exit {status}\n{output[-2000:]}')
        self.original = digest(self.program())
        if self.options.has_effect:
            status, output = run(f"python3 '{self.tree}/tests/mutants/observables.py' '{self.program()}' "
                                 f"> '{self.out}/observables.tsv'", 600)
            if status != 0:
                sys.exit(f'mutants: error: observables.py: exit {status}\n{output[-2000:]}')

    def threads(self):
        return max(1, os.cpu_count() // self.options.jobs)

    def build_command(self, threads):
        # One workshop takes from the compiler cache what another has compiled.
        return f"CCACHE_BASEDIR='{self.out}' CCACHE_NOHASHDIR=1 cmake --build '{self.build_dir}' -j {threads} --target {self.options.target}"

    def program(self):
        return os.path.join(self.build_dir, 'ticktrue')

    def judge(self, check_seed):
        """killed, survived, same (the program has the same bytes), no_effect (no observable moves by 1 %) or unbuildable,
        and a word on it"""
        status, output = run(self.build_command(self.threads()), 1200)
        if status != 0:
            return 'unbuildable', ''
        if digest(self.program()) == self.original:
            return 'same', ''
        if self.options.has_effect:
            status, output = run(f"python3 '{self.tree}/tests/mutants/observables.py' '{self.program()}' "
                                 f"'{self.out}/observables.tsv'", 600)
            if status == 0:
                return 'no_effect', ''
        return self.check(check_seed)

    def check(self, check_seed):
        """killed or survived, and a word on it"""
        command = self.options.check.format(program=self.program(), seed=check_seed, time=self.options.time,
                                            out=os.path.join(self.out, 'check'), root=self.tree, build=self.build_dir,
                                            threads=self.threads())
        start = time.monotonic()
        status, output = run(command, self.options.time + self.options.grace)
        seconds = time.monotonic() - start
        if status == 0:
            return 'survived', f'{seconds:.0f} s'
        how = 'no end' if status is None else f'exit {status}'
        first = next((l.strip() for l in output.split('\n') if self.options.word in l), '')
        return 'killed', f'{how} after {seconds:.0f} s {first}'[:160].replace('\t', ' ')

    def examine(self, mutant):
        """verdict and a word on it"""
        if isinstance(mutant, Patch):
            return self.examine_patch(mutant)
        path = os.path.join(self.tree, mutant.name)
        with open(path) as original:
            text = original.read()
        changed = text.split('\n')
        changed[mutant.number] = mutant.after
        with open(path, 'w') as file:
            file.write('\n'.join(changed))
        try:
            return self.judge(mutant.check_seed)
        finally:
            with open(path, 'w') as file:
                file.write(text)


    def examine_patch(self, patch):
        apply = f"patch -s -p1 -d '{self.tree}' {{}} < '{patch.path}'"
        status, output = run(apply.format(''), 60)
        if status != 0:
            sys.exit(f'mutants: error: {patch.path}: cannot be applied\n{output}')
        try:
            return self.judge(patch.check_seed)
        finally:
            run(apply.format('-R'), 60)


Patch = collections.namedtuple('Patch', 'draw name number before after check_seed path')
Mutant = collections.namedtuple('Mutant', 'draw name number before after check_seed')


def draw_mutants(lines, seed):
    """Mutants without end, the same for the same seed."""
    source = random.Random(seed)
    for draw in itertools.count(1):
        name, number, line = lines[source.randrange(len(lines))]
        begin, end, other = source.choice(tokens_of(line))
        yield Mutant(draw, name, number, line, line[:begin] + other + line[end:], source.randrange(1 << 32))


def patches_of(paths, seed):
    """Faults planted by hand, one to a file."""
    source = random.Random(seed)
    for draw, path in enumerate(paths, 1):
        yield Patch(draw, path, 0, '', '', source.randrange(1 << 32), os.path.abspath(path))


class Mutants:
    """Hands out mutants in the order of their draws, and writes down what became of them."""

    def __init__(self, options):
        self.options = options
        self.results = os.path.join(options.out, 'results.tsv')
        self.lock = threading.Lock()
        self.counts = {'killed': 0, 'survived': 0, 'same': 0, 'unbuildable': 0, 'equivalent': 0, 'no_effect': 0}
        self.under_way = 0
        self.deadline = time.monotonic() + options.limit if options.limit else None

    def done(self):
        if not os.path.exists(self.results):
            return {}
        with open(self.results) as table:
            rows = [line.rstrip('\n').split('\t') for line in table][1:]
        return {int(row[0]): row for row in rows}

    def next_mutant(self, mutants, done):
        """The next one to examine; nothing when enough are judged or the time is over."""
        while True:
            with self.lock:
                judged = self.counts['killed'] + self.counts['survived']
                if judged >= self.options.count:
                    return None
                if judged + self.under_way < self.options.count:
                    if self.deadline and time.monotonic() > self.deadline:
                        return None
                    mutant = next(mutants, None)
                    if mutant is None:
                        return None
                    if mutant.draw not in done:
                        self.under_way += 1
                        return mutant
                    self.counts[done[mutant.draw][5]] += 1
                    continue
            time.sleep(1)  # mutants in progress may turn out to be equal programs

    def work(self, workshop, mutants, done):
        while True:
            mutant = self.next_mutant(mutants, done)
            if mutant is None:
                return
            why = self.equivalent.get(key_of(mutant, self.lines)) if self.equivalent else None
            verdict, how = ('equivalent', why) if why else workshop.examine(mutant)
            with self.lock:
                self.under_way -= 1
                self.counts[verdict] += 1
                row = [str(mutant.draw), mutant.name, str(mutant.number + 1), mutant.before.strip(), mutant.after.strip(),
                       verdict, how]
                with open(self.results, 'a') as table:
                    table.write('\t'.join(row) + '\n')
                print(f"{mutant.draw}: {verdict} {how}: {mutant.name}:{mutant.number + 1}: {mutant.after.strip()}", flush=True)

    def run_all(self):
        options = self.options
        lines = self.lines = candidates_of(options.root, options.files)
        self.equivalent = {} if options.patches else equivalents(options.equivalent)
        os.makedirs(options.out, exist_ok=True)
        done = self.done() if options.resume else {}
        if not done:
            with open(self.results, 'w') as table:
                table.write('draw\tfile\tline\tbefore\tafter\tverdict\thow\n')
        workshops = [Workshop(options, number) for number in range(options.jobs)]
        for workshop in workshops:
            workshop.prepare()
        if not done:
            verdict, how = workshops[0].check(options.seed)
            if verdict == 'killed':
                sys.exit(f'mutants: error: the check fails without any mutant: {how}')
            print(f'without a mutant: {verdict} {how}', flush=True)
        if options.patches:
            options.count = len(options.patches)
            mutants = patches_of(options.patches, options.seed)
        else:
            mutants = draw_mutants(lines, options.seed)
        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
            for worker in [pool.submit(self.work, workshop, mutants, done) for workshop in workshops]:
                worker.result()
        counts = self.counts
        judged = counts['killed'] + counts['survived']
        if judged < options.count:
            print('mutants: out of time: continue with --resume', file=sys.stderr)
        print(f"{judged} mutants: {counts['killed']} killed, {counts['survived']} survived; besides {counts['same']} with "
              f"the same program, {counts['unbuildable']} that did not build, {counts['equivalent']} that cannot change a bit"
              f"{', %d that move no observable' % counts['no_effect'] if options.has_effect else ''}; "
              f"{self.results}")
        return 0 if counts['survived'] == 0 else 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--root', default='.', help='the source tree')
    parser.add_argument('--out', default='out/mutants', help='where the copy is built and results are written')
    parser.add_argument('--set', choices=SETS, default='caches', help='what is changed, and the check that should notice: '
                        'files that cache or batch are soaked, solvers, joints and integrators studied (if an observable moves by '
                        '1 %%: observables.py), all others tested')
    parser.add_argument('--files', nargs='*', help='files to change (default: those of the set)')
    parser.add_argument('--patches', nargs='*', help='faults planted by hand, as patches, instead of mutants')
    parser.add_argument('--equivalent', default=os.path.join(os.path.dirname(__file__), 'equivalent.tsv'),
                        help='mutants that cannot change a bit, each with its reason: they are counted apart, not judged ("" for none)')
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--count', type=int, default=100, help='mutants that build into another program')
    parser.add_argument('--target', help='what is built before the check (default: ticktrue, and ticktrue_tests where they are the check)')
    parser.add_argument('--check', help='a shell command instead of that of the set; {program}, {seed}, {time}, {threads}, '
                        '{out}, {root}, {build} are filled in')
    parser.add_argument('--word', help='a line of the output with this is kept as the reason')
    parser.add_argument('--time', type=int, default=300, help='seconds that a soak, or a test, may take')
    parser.add_argument('--jobs', type=int, default=1, help='mutants at once; processors are divided among them')
    parser.add_argument('--grace', type=int, help='seconds more until it counts as one that does not end (default: 120, 3000 with tests)')
    parser.add_argument('--limit', type=int, default=0, help='seconds after which no new mutant is begun')
    parser.add_argument('--resume', action='store_true', help='go on where an earlier run with the same seed ended')
    options = parser.parse_args()
    chosen = SETS[options.set]
    options.has_tests = chosen.has_tests
    options.has_effect = chosen.has_effect
    options.files = options.files or chosen.files
    options.check = options.check or chosen.check
    options.word = options.word or chosen.word
    options.grace = options.grace or chosen.grace
    options.target = options.target or ('ticktrue ticktrue_tests' if chosen.has_tests else 'ticktrue')
    options.out = os.path.abspath(options.out)
    options.root = os.path.abspath(options.root)
    return Mutants(options).run_all()


if __name__ == '__main__':
    sys.exit(main())
