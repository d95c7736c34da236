// What every part of the page uses: small functions, numbers in words, the frames as they are coded in the page.

const data = JSON.parse(document.getElementById('data').textContent);
const report = data.verify;
const film = data.film;
const canUnpack = typeof DecompressionStream !== 'undefined';
if (film && film.playback && !canUnpack) film.no_poses = 'This browser cannot unpack the poses: it is older than 2023.';
const playback = film && canUnpack ? film.playback : null;

// --- small things -------------------------------------------------------------------------------------------------

const byId = (id) => document.getElementById(id);

/** An element with a class, and children that are elements or text. */
function make(tag, className, ...children) {
  const element = document.createElement(tag);
  if (className) element.className = className;
  for (const child of children) if (child !== null && child !== undefined) element.append(child);
  return element;
}

/** Marks an element as showing a fact, by its path in the JSON of `verify --json`. */
function fact(element, path) {
  element.dataset.fact = path;
  return element;
}

const count = (number, noun) => number.toLocaleString('en-US') + ' ' + noun + (number === 1 ? '' : 's');
const whole = (number) => Number(number).toLocaleString('en-US');
const dot = ' \u00b7 ';
const seconds = (value) => value.toFixed(3) + ' s';
const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);
const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

/** Three or four digits, with a power of ten where that is shorter. */
function shortNumber(value) {
  if (!Number.isFinite(value)) return 'not finite';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-3) return value.toExponential(2).replace(/\.?0+e/, 'e').replace('e+', 'e');
  return String(Number(value.toPrecision(4)));
}

function bytesOf(text) {
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; ++i) bytes[i] = raw.charCodeAt(i);
  return bytes;
}
/** The bytes of a zlib stream. */
async function inflated(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
function floatsOf(text) {
  const bytes = bytesOf(text);
  const view = new DataView(bytes.buffer);
  return Float32Array.from({ length: bytes.length / 4 }, (_, i) => view.getFloat32(4 * i, true));
}
function doublesOf(text) {
  const bytes = bytesOf(text);
  const view = new DataView(bytes.buffer);
  return Float64Array.from({ length: bytes.length / 8 }, (_, i) => view.getFloat64(8 * i, true));
}

/** Index of the last entry that is not above the value; 0 if all are. */
function lastIndexBelow(sorted, value) {
  let low = 0;
  let high = sorted.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sorted[middle] <= value) low = middle + 1;
    else high = middle;
  }
  return Math.max(0, low - 1);
}

// --- frames -------------------------------------------------------------------------------------------------------

/** Reads the numbers of tool/report_page/frame_coding.h. */
class Numbers {
  constructor(bytes) {
    this.bytes = bytes;
    this.at = 0;
  }
  next() {
    let value = 0;
    for (let scale = 1; this.at < this.bytes.length; scale *= 128) {
      const byte = this.bytes[this.at++];
      value += (byte & 127) * scale;
      if (byte < 128) break;
    }
    return value % 2 === 0 ? value / 2 : -(value + 1) / 2;
  }
}

/** What a lane is expected to be next, from the two values before. */
function predict(ticks, values, i) {
  if (i === 0) return 0;
  if (i === 1) return values[0];
  const ahead = ticks[i] - ticks[i - 1];
  const behind = ticks[i - 1] - ticks[i - 2];
  const moved = values[i - 1] - values[i - 2];
  return clamp(values[i - 1] + Math.floor((moved * ahead) / behind + 0.5), -536870912, 536870912);
}

/** Bodies over frames; poses in metres and radians. */
class Track {
  constructor(coded, grid, numbers) {
    this.ticks = coded.ticks;
    this.ids = coded.ids;
    this.names = coded.names;
    this.figure = coded.figure;
    this.presence = coded.presence;
    this.lanes = [];
    this.length = grid.length;
    this.turn = (2 * Math.PI) / grid.angle_count;
    for (const parts of coded.presence) this.lanes.push(this.decodeBody(numbers, parts));
  }
  decodeBody(numbers, parts) {
    const ticks = [];
    for (let p = 0; p < parts.length; p += 2)
      for (let i = 0; i < parts[p + 1]; ++i) ticks.push(this.ticks[parts[p] + i]);
    const lanes = [];
    for (let lane = 0; lane < 3; ++lane) {
      const values = new Int32Array(ticks.length);
      for (let i = 0; i < ticks.length; ++i) values[i] = numbers.next() + predict(ticks, values, i);
      lanes.push(values);
    }
    return lanes;
  }
  /** Where in its lanes a body stands at a frame; -1 where it is not there. */
  slot(body, frame) {
    const parts = this.presence[body];
    let before = 0;
    for (let p = 0; p < parts.length; p += 2) {
      if (frame < parts[p]) return -1;
      if (frame < parts[p] + parts[p + 1]) return before + frame - parts[p];
      before += parts[p + 1];
    }
    return -1;
  }
  /** Fills `pose` with x, y, angle; `share` of the way to the next frame. False: the body is not there. */
  pose(body, frame, share, pose) {
    const at = this.slot(body, frame);
    if (at < 0) return false;
    const next = share > 0 && this.slot(body, frame + 1) === at + 1 ? at + 1 : at;
    const [x, y, angle] = this.lanes[body];
    pose.x = (x[at] + (x[next] - x[at]) * share) * this.length;
    pose.y = (y[at] + (y[next] - y[at]) * share) * this.length;
    pose.angle = (angle[at] + (angle[next] - angle[at]) * share) * this.turn;
    return true;
  }
  bodyCount() {
    return this.ids.length;
  }
}

const trackOf = async (coded) => new Track(coded, playback.grid, new Numbers(await inflated(bytesOf(coded.numbers))));
const track = playback ? await trackOf(playback.bodies) : null;
const ghosts = playback && playback.ghosts ? await trackOf(playback.ghosts) : null;
const times = playback ? doublesOf(playback.times) : null;
const tickCount = film ? film.tick_count : 0;
const focus = data.focus;  // ticks done
const namedBodies = playback ? playback.named : [];
