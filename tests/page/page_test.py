#!/usr/bin/env python3
# Opens pages of `ticktrue report` in a headless Chromium, and uses them like a person.
# SPDX-License-Identifier: MIT
#
#   page_test.py TICKTRUE PLANT_FAULT
#
# Verified: no page writes an error to the console; every shown fact equals that of `verify --json`. Bodies are drawn
# where `replay` reports them, to half a step of the grid. Playing stops at the divergence and marks the affected body.
# Keys, buttons, wheel, fingers, timeline and theme work. On a phone nothing exceeds the screen; on paper the report has
# no buttons. Exit 77, which ctest counts as skipped: chromium or chromedriver is missing. Only needs Python's standard
# library.
import base64
import json
import os
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request

SKIPPED = 77
failures = []


def check(is_true, what):
    if not is_true:
        failures.append(what)
        print('page_test: failed: ' + what, file=sys.stderr)


class Browser:
    """A session of chromedriver, spoken to as the WebDriver standard has it."""

    def __init__(self, driver, browser):
        with socket.socket() as free:
            free.bind(('127.0.0.1', 0))
            port = free.getsockname()[1]
        self.process = subprocess.Popen([driver, '--port=%d' % port], stdout=subprocess.DEVNULL,
                                        stderr=subprocess.DEVNULL)
        self.base = 'http://127.0.0.1:%d' % port
        for _ in range(200):
            try:
                self.call('GET', '/status')
                break
            except (urllib.error.URLError, ConnectionError):
                time.sleep(0.05)
        arguments = ['--headless=new', '--no-sandbox', '--disable-gpu', '--disable-dev-shm-usage',
                     '--window-size=1200,900']
        wanted = {'goog:chromeOptions': {'binary': browser, 'args': arguments}, 'goog:loggingPrefs': {'browser': 'ALL'}}
        made = self.call('POST', '/session', {'capabilities': {'alwaysMatch': wanted}})
        self.base += '/session/' + made['sessionId']

    def call(self, method, path, body=None):
        request = urllib.request.Request(self.base + path, method=method, headers={'Content-Type': 'application/json'},
                                         data=None if body is None else json.dumps(body).encode())
        with urllib.request.urlopen(request, timeout=60) as answer:
            return json.load(answer)['value']

    def open(self, path):
        self.call('POST', '/url', {'url': 'file://' + path})
        for _ in range(500):  # poses are unpacked after the page has loaded
            if self.run('return document.body.dataset.ready') == 'yes':
                return
            time.sleep(0.01)
        check(False, path + ' was not ready after 5 s')

    def run(self, script, *arguments):
        return self.call('POST', '/execute/sync', {'script': script, 'args': list(arguments)})

    def errors(self):
        entries = self.call('POST', '/se/log', {'type': 'browser'})
        return [entry['message'] for entry in entries if entry['level'] == 'SEVERE']

    def screen(self, width, height, is_mobile):
        self.call('POST', '/goog/cdp/execute', {
            'cmd': 'Emulation.setDeviceMetricsOverride',
            'params': {'width': width, 'height': height, 'deviceScaleFactor': 1, 'mobile': is_mobile}})

    def press(self, key):
        code = {'End': '\ue010', 'Home': '\ue011', 'ArrowLeft': '\ue012', 'ArrowRight': '\ue014'}.get(key, key)
        self.call('POST', '/actions', {'actions': [{'type': 'key', 'id': 'keyboard', 'actions': [
            {'type': 'keyDown', 'value': code}, {'type': 'keyUp', 'value': code}]}]})

    def place(self, selector, share_x, share_y):
        """Where a place of an element is on the screen, which shows it then."""
        x, y = self.run('const e = document.querySelector(arguments[0]); e.scrollIntoView({block: "center"});'
                        'const b = e.getBoundingClientRect();'
                        'return [b.left + b.width * arguments[1], b.top + b.height * arguments[2]]',
                        selector, share_x, share_y)
        return int(x), int(y)

    def wheel(self, selector, delta_y):
        x, y = self.place(selector, 0.5, 0.5)
        self.call('POST', '/actions', {'actions': [{'type': 'wheel', 'id': 'wheel', 'actions': [
            {'type': 'scroll', 'duration': 0, 'x': x, 'y': y, 'deltaX': 0, 'deltaY': delta_y}]}]})

    def spread_fingers(self, selector, begin, end):
        """Two fingers, side by side at `begin` px from the middle, move to `end` px from it."""
        x, y = self.place(selector, 0.5, 0.5)
        self.call('POST', '/actions', {'actions': [{
            'type': 'pointer', 'id': name, 'parameters': {'pointerType': 'touch'}, 'actions': [
                {'type': 'pointerMove', 'duration': 0, 'x': x + side * begin, 'y': y},
                {'type': 'pointerDown', 'button': 0},
                {'type': 'pointerMove', 'duration': 100, 'x': x + side * end, 'y': y},
                {'type': 'pointerUp', 'button': 0}]} for name, side in [('thumb', -1), ('finger', 1)]]})

    def point(self, selector, share_x, share_y):
        """A click of the mouse at a place of an element."""
        x, y = self.place(selector, share_x, share_y)
        self.call('POST', '/actions', {'actions': [{
            'type': 'pointer', 'id': 'mouse', 'parameters': {'pointerType': 'mouse'}, 'actions': [
                {'type': 'pointerMove', 'duration': 0, 'x': x, 'y': y},
                {'type': 'pointerDown', 'button': 0}, {'type': 'pointerUp', 'button': 0}]}]})

    def state(self):
        return self.run('return ticktrue.state()')

    def wait_for_pause(self, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if not self.state()['isPlaying']:
                return True
            time.sleep(0.05)
        return False

    def close(self):
        try:
            self.call('DELETE', '')
        except (urllib.error.URLError, ConnectionError, OSError):
            pass
        self.process.terminate()
        self.process.wait(10)


class Bench:
    """A folder with traces and pages made by the tools."""

    def __init__(self, tool, inject_fault, folder):
        self.tool, self.inject_fault, self.folder = tool, inject_fault, folder

    def path(self, name):
        return os.path.join(self.folder, name)

    def call(self, *words, codes=(0,), program=None):
        done = subprocess.run([program or self.tool, *words], cwd=self.folder, capture_output=True, text=True,
                              timeout=120)
        if done.returncode not in codes:
            sys.exit('page_test: error: %s: exit %d\n%s' % (' '.join(words), done.returncode, done.stderr))
        return done.stdout

    def page(self, name, *more, code=0):
        self.call('report', name + '.ttr', '-o', name + '.html', '--force', *more, codes=(code,))
        return self.path(name + '.html')

    def verified(self, name, code=0):
        return json.loads(self.call('verify', name + '.ttr', '-j', '1', '--json', codes=(code,)))


def follow(report, path):
    """What stands at a path of the JSON; None where that is no single value."""
    at = report
    for part in path.split('.'):
        if isinstance(at, list) and part.isdigit() and int(part) < len(at):
            at = at[int(part)]
        elif isinstance(at, dict) and part in at:
            at = at[part]
        else:
            return None
    return at


def compare_facts(browser, report, minimum):
    facts = browser.run('return [...document.querySelectorAll("[data-fact]")].map('
                        '(e) => [e.dataset.fact, e.dataset.value || e.textContent])')
    compared = 0
    for path, shown in facts:
        value = follow(report, path)
        if value is None or isinstance(value, (dict, list)):
            continue
        if isinstance(value, bool):
            expected = str(value).lower()
        elif isinstance(value, int):
            expected, shown = str(value), shown.replace(',', '').split(' of ')[0]
        elif isinstance(value, float):
            expected = '%.3f s' % value
        else:
            expected = value
        if path.endswith('.name') or path.endswith('.stage') or path.endswith('.column'):
            check(expected in shown, '%s: shown %r, expected %r in it' % (path, shown, expected))
        else:
            check(shown == expected, '%s: shown %r, expected %r' % (path, shown, expected))
        compared += 1
    check(compared >= minimum, 'only %d facts on the page: %r' % (compared, facts))


def compare_poses(browser, bench, name, tick, names):
    """Bodies drawn at the end of a tick stand where `replay` says."""
    line = json.loads(bench.call('replay', name + '.ttr', '--format', 'jsonl', '--ticks', '%d..%d' % (tick, tick),
                                 codes=(0, 1)).splitlines()[0])
    browser.run('ticktrue.seek(arguments[0])', tick + 1)
    step = browser.run('return ticktrue.data.film.playback.grid.length')
    for body in line['bodies']:
        if body['name'] not in names:
            continue
        pose = browser.run('return ticktrue.pose(arguments[0])', body['name'])
        x, y = body['position'] if 'position' in body else (body['x'], body['y'])
        check(abs(pose['x'] - x) <= step / 2 and abs(pose['y'] - y) <= step / 2,
              '%s at tick %d: drawn at %r, is at %r' % (body['name'], tick, pose, (x, y)))


# Canvas pixels in the colour of a fault.
red_pixels = '''
const canvas = document.getElementById('world');
const image = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
let count = 0;
for (let i = 0; i < image.length; i += 4)
  if (Math.abs(image[i] - 192) < 12 && Math.abs(image[i + 1] - 42) < 12 && Math.abs(image[i + 2] - 37) < 12) ++count;
return count;
'''


# The share of red in the upper and the lower strip of two traces, between two ticks.
red_strips = '''
const canvas = document.getElementById('strip');
const scale = canvas.width / canvas.clientWidth;
const margin = 12;
const [left, right] = [arguments[0], arguments[1]].map((tick) =>
  Math.round((margin + ((canvas.clientWidth - 2 * margin) * tick) / ticktrue.data.film.tick_count) * scale));
return [19, 27].map((y) => {
  const image = canvas.getContext('2d').getImageData(left, Math.round(y * scale), right - left, 1).data;
  let count = 0;
  for (let i = 0; i < image.length; i += 4) if (image[i] > 180 && image[i + 1] < 110 && image[i + 2] < 110) ++count;
  return count / (right - left);
});
'''


def check_console(browser, where):
    messages = browser.errors()
    check(messages == [], '%s: console: %r' % (where, messages))


def check_zoom(browser):
    def scale():
        return browser.state()['pixelsPerMetre']

    def becomes(least, most):
        """Wheel and fingers reach the page after they were asked for."""
        end = time.monotonic() + 5
        while not least * fitted < scale() < most * fitted and time.monotonic() < end:
            time.sleep(0.05)
        return least * fitted < scale() < most * fitted
    browser.press('0')
    fitted = scale()
    browser.point('#world', 0.5, 0.1)
    browser.wheel('#world', -300)
    check(becomes(1.3, 2), 'the wheel zooms from %r to %r' % (fitted, scale()))
    browser.wheel('#world', 300)
    check(becomes(0.99, 1.01), 'the wheel does not zoom back: %r, %r' % (fitted, scale()))
    browser.press('0')
    browser.spread_fingers('#world', 40, 120)
    check(becomes(2.5, 3.5), 'two fingers zoom from %r to %r' % (fitted, scale()))
    browser.press('0')
    check(scale() == fitted, '0 does not show everything again')


def check_paper(browser):
    """In the dark theme that the page has by now: paper is white all the same."""
    browser.call('POST', '/goog/cdp/execute', {'cmd': 'Emulation.setEmulatedMedia', 'params': {'media': 'print'}})
    shown = browser.run('const shown = (id) => getComputedStyle(document.getElementById(id)).display !== "none";'
                        'return ["verdict", "world", "strip", "plots", "controls", "theme"].map(shown)')
    check(shown == [True, True, True, True, False, False], 'on paper there is %r' % shown)
    check(browser.run('return getComputedStyle(document.body).backgroundColor') == 'rgb(255, 255, 255)',
          'paper is not white')
    check(browser.run('return document.documentElement.scrollWidth <= window.innerWidth'), 'on paper something sticks out')
    browser.call('POST', '/goog/cdp/execute', {'cmd': 'Emulation.setEmulatedMedia', 'params': {'media': ''}})
    pdf = base64.b64decode(browser.call('POST', '/print', {'background': True}))
    pages = len(re.findall(rb'/Type\s*/Page\b', pdf))
    check(pdf.startswith(b'%PDF') and 1 <= pages <= 4, 'printing gives %d pages in %d bytes' % (pages, len(pdf)))
    check(pdf.count(b'/Subtype /Image') >= 3, 'playback and plots are not on the printed pages')


def use_matching_page(browser, bench):
    bench.call('record', 'pyramid?base=6&substeps=4', '--ticks', '300', '--checkpoint-interval', '100', '-o', 'match.ttr')
    browser.open(bench.page('match'))
    report = bench.verified('match')
    check(browser.run('return ticktrue.data.verify') == report, 'match: the JSON in the page is not that of verify')
    compare_facts(browser, report, 5)
    compare_poses(browser, bench, 'match', 123, ['box_1', 'box_9', 'box_20'])
    check(browser.run('return document.getElementById("where").hidden'), 'match: a divergence is shown')
    browser.press('End')
    check(browser.state()['ticksDone'] == 300, 'End does not go to the end')
    browser.press('ArrowLeft')
    check(browser.state()['ticksDone'] == 299, 'the left arrow does not go a tick back')
    browser.press('Home')
    browser.press('ArrowRight')
    check(browser.state()['ticksDone'] == 1, 'the right arrow does not go a tick on')
    browser.point('#timeline', 0.5, 0.4)
    check(abs(browser.state()['ticksDone'] - 150) <= 1, 'a click on the timeline goes to %r' % browser.state())
    browser.point('#toggle', 0.5, 0.5)
    check(browser.state()['isPlaying'], 'the button does not play')
    time.sleep(0.3)
    browser.press(' ')
    check(not browser.state()['isPlaying'], 'space does not pause')
    check(browser.state()['ticksDone'] > 150, 'playing does not move on')
    before = browser.run('return getComputedStyle(document.body).backgroundColor')
    browser.point('#theme', 0.5, 0.5)
    check(browser.run('return getComputedStyle(document.body).backgroundColor') != before, 'the theme does not change')
    check(browser.run(red_pixels) == 0, 'match: something is ringed')
    check_zoom(browser)
    check_paper(browser)
    check_console(browser, 'match')


def use_diverging_page(browser, bench):
    bench.call('match.ttr', 'diverged.ttr', '137', '9', '24', 'cells', program=bench.inject_fault)
    browser.open(bench.page('diverged', code=1))
    report = bench.verified('diverged', code=1)
    check(report['verdict'] == 'diverged' and report['divergence']['tick'] == 137, 'the fault was not found')
    check(browser.run('return ticktrue.data.verify') == report, 'diverged: the JSON in the page is not that of verify')
    compare_facts(browser, report, 14)
    check(browser.state()['ticksDone'] == 138, 'the page does not open at the divergence')
    check(browser.state()['ringed'] == 'box_9', 'ringed: %r' % browser.state())
    browser.press('Home')
    check(browser.run(red_pixels) == 0, 'something is ringed before the divergence')
    browser.run('const s = document.getElementById("speed"); s.value = "16"; s.dispatchEvent(new Event("change"))')
    browser.press(' ')
    check(browser.wait_for_pause(10), 'playing does not stop at the divergence')
    check(browser.state()['ticksDone'] == 138, 'playing stopped at %r' % browser.state())
    check(browser.state()['ringed'] == 'box_9', 'ringed: %r' % browser.state())
    check(browser.run(red_pixels) > 60, 'the ring is not drawn')
    check('box_9' in browser.run('return document.getElementById("stage-note").textContent'), 'the body is not named')
    check('box_9' in browser.run('return document.getElementById("announce").textContent'), 'the stop is not announced')
    browser.press(' ')
    check(browser.wait_for_pause(10), 'playing does not reach the end')
    check(browser.state()['ticksDone'] == 300, 'behind the divergence playing stopped at %r' % browser.state())
    check_console(browser, 'diverged')


def use_other_pages(browser, bench):
    browser.open(bench.page('match', '--against', 'diverged.ttr', code=1))
    check(browser.run('return !document.getElementById("against").hidden'), 'against: not shown')
    check(browser.run('return !document.getElementById("ghosts-label").hidden'), 'against: no ghosts')
    check(browser.run('return ticktrue.data.against.diff.divergence.tick') == 137, 'against: another tick')
    check(browser.run('const verdict = document.getElementById("verdict");'
                      'return [verdict.dataset.tone, document.getElementById("verdict-name").textContent]') ==
          ['bad', 'Different'], 'against: the headline is not that the traces differ')
    before, behind = browser.run(red_strips, 10, 130), browser.run(red_strips, 140, 298)
    # The lower strip is hatched, because its recorded states are known.
    check(before == [0, 0] and behind[0] > 0.95 and behind[1] > 0.4,
          'against: of the strips %r is red before the difference, %r behind it' % (before, behind))
    bench.call('record', 'stack', '--ticks', '60', '-o', 'stack.ttr')
    bench.call('record', 'stack?jitter=0.01', '--ticks', '60', '-o', 'jittered.ttr')
    browser.open(bench.page('stack', '--against', 'jittered.ttr', code=1))
    red = browser.run(red_strips, 5, 58)
    check(red[0] > 0.95 and red[1] > 0.95, 'two traces that match and differ: of the strips %r is red' % red)
    browser.open(bench.path('match.html'))
    for key in ['g', 'n', '+', '+', '-', '0', 'd']:
        browser.press(key)
    check(browser.state()['ticksDone'] == 138, 'd does not go to where they part')

    bench.call('import', 'mouse', '--model', '3', '--seconds', '6', '--scene', 'thesis', '-o', 'session.jsonl')
    bench.call('record', 'thesis', '--inputs', 'session.jsonl', '-o', 'session.ttr')
    browser.open(bench.page('session'))
    browser.screen(390, 800, True)
    check(browser.run('return document.documentElement.scrollWidth <= window.innerWidth'),
          'on a phone something sticks out')
    row = browser.run('const row = document.querySelector("#inputs-table tbody tr"); row.click();'
                      'return row.dataset.tick')
    check(browser.state()['ticksDone'] == int(row) + 1, 'a click on an input does not go to its tick')
    browser.screen(1200, 900, False)

    with open(bench.path('match.ttr'), 'rb') as whole:
        trace = whole.read()
    for name, size, code in [('cut', len(trace) * 2 // 3, 3), ('start', 300, 3)]:
        with open(bench.path(name + '.ttr'), 'wb') as cut:
            cut.write(trace[:size])
        browser.open(bench.page(name, code=code))
        report = bench.verified(name, code=code)
        compare_facts(browser, report, 2)
    check_console(browser, 'other pages')


def main():
    if len(sys.argv) != 3:
        sys.exit('usage: page_test.py TICKTRUE PLANT_FAULT')
    driver = shutil.which('chromedriver')
    browser_path = next(filter(None, map(shutil.which, ['chromium', 'chromium-browser', 'google-chrome'])), None)
    if not driver or not browser_path:
        print('page_test: skipped: no chromium or no chromedriver (Debian: chromium chromium-driver)')
        sys.exit(SKIPPED)
    folder = tempfile.mkdtemp(prefix='ticktrue_page_')
    browser = Browser(driver, browser_path)
    try:
        bench = Bench(os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]), folder)
        use_matching_page(browser, bench)
        use_diverging_page(browser, bench)
        use_other_pages(browser, bench)
    finally:
        browser.close()
        shutil.rmtree(folder, ignore_errors=True)
    print('page_test: %s' % ('ok' if not failures else '%d failures' % len(failures)))
    sys.exit(1 if failures else 0)


main()
