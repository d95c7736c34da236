// The bodies on a canvas.

// --- colours and canvases -----------------------------------------------------------------------------------------

let style = getComputedStyle(document.documentElement);
let isPrinting = false;
const color = (name) => style.getPropertyValue('--' + name).trim();

/** The canvas in pixels of the screen, cleared, with one unit to a CSS pixel. */
function prepare(canvas) {
  const ratio = isPrinting ? 2 : Math.min(window.devicePixelRatio || 1, 3);
  const width = canvas.clientWidth;
  const height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext('2d');
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height, ratio };
}

const font = '11.5px system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif';

// --- the world ----------------------------------------------------------------------------------------------------

const camera = { x: 0, y: 0, scale: 1, isFitted: true };  // centre, m; px per m
let figures = [];

/** The path of one outline in the body's frame, m. */
function outlinePath(outline) {
  const path = new Path2D();
  const points = outline.points;
  const radius = outline.radius || 0;
  const n = points.length / 2;
  if (n === 1) {
    path.arc(points[0], points[1], radius, 0, 2 * Math.PI);
    path.moveTo(points[0], points[1]);
    path.lineTo(points[0] + radius, points[1]);  // so that turning is seen
    return path;
  }
  if (outline.line || radius === 0) {
    path.moveTo(points[0], points[1]);
    for (let i = 1; i < n; ++i) path.lineTo(points[2 * i], points[2 * i + 1]);
    if (!outline.line || outline.closed) path.closePath();
    return path;
  }
  // Rounded: an arc about each point, from the normal of the edge before to that of the edge behind.
  for (let i = 0; i < n; ++i) {
    const [ax, ay, bx, by, cx, cy] = [(i + n - 1) % n, i, (i + 1) % n].flatMap((p) => [points[2 * p], points[2 * p + 1]]);
    const before = Math.atan2(by - ay, bx - ax) - Math.PI / 2;
    const behind = Math.atan2(cy - by, cx - bx) - Math.PI / 2;
    path.arc(bx, by, radius, before, behind);
  }
  path.closePath();
  return path;
}

function reachOf(figure) {
  let reach = 0;
  for (const outline of figure.outlines)
    for (let i = 0; i < outline.points.length; i += 2)
      reach = Math.max(reach, Math.hypot(outline.points[i], outline.points[i + 1]) + (outline.radius || 0));
  return reach;
}

function readFigures() {
  figures = playback.figures.map((figure) => ({
    type: figure.type,
    reach: reachOf(figure),
    outlines: figure.outlines.map((outline) => ({ path: outlinePath(outline), isFilled: !outline.line, isSensor: !!outline.sensor })),
  }));
}

function fitCamera(width, height) {
  const [left, bottom, right, top] = playback.view;
  camera.x = (left + right) / 2;
  camera.y = (bottom + top) / 2;
  camera.scale = Math.min(width / (right - left), height / (top - bottom));
}

function setZoomed() {
  camera.isFitted = false;
  byId('world').classList.add('is-zoomed');
}
function zoom(factor, x, y) {
  const canvas = byId('world');
  const dx = (x === undefined ? 0 : x - canvas.clientWidth / 2);
  const dy = (y === undefined ? 0 : canvas.clientHeight / 2 - y);
  const before = camera.scale;
  setZoomed();
  camera.scale = clamp(camera.scale * factor, 1e-4, 1e7);
  camera.x += dx / before - dx / camera.scale;
  camera.y += dy / before - dy / camera.scale;
  drawWorld();
}
function fit() {
  camera.isFitted = true;
  byId('world').classList.remove('is-zoomed');
  drawWorld();
}

/** 1, 2 or 5 times a power of ten, at least the value. */
function niceStep(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  for (const factor of [1, 2, 5]) if (factor * power >= value * 0.999999) return factor * power;
  return 10 * power;
}

function drawGrid(context, width, height) {
  const step = niceStep(70 / camera.scale);
  context.strokeStyle = color('grid');
  context.lineWidth = 1;
  context.beginPath();
  const left = camera.x - width / 2 / camera.scale;
  const bottom = camera.y - height / 2 / camera.scale;
  for (let x = Math.ceil(left / step) * step; (x - left) * camera.scale < width; x += step) {
    const at = Math.round((x - left) * camera.scale) + 0.5;
    context.moveTo(at, 0);
    context.lineTo(at, height);
  }
  for (let y = Math.ceil(bottom / step) * step; (y - bottom) * camera.scale < height; y += step) {
    const at = Math.round(height - (y - bottom) * camera.scale) + 0.5;
    context.moveTo(0, at);
    context.lineTo(width, at);
  }
  context.stroke();
  const length = step * camera.scale;
  context.strokeStyle = color('quiet');
  context.fillStyle = color('quiet');
  context.beginPath();
  context.moveTo(12.5, height - 16);
  context.lineTo(12.5, height - 11.5);
  context.lineTo(12.5 + length, height - 11.5);
  context.lineTo(12.5 + length, height - 16);
  context.stroke();
  context.font = font;
  context.fillText(shortNumber(step) + ' m', 18, height - 17);
}

/** Puts the context into the frame of a body. */
function place(view, pose) {
  const { context, width, height, ratio } = view;
  const scale = camera.scale * ratio;
  const cos = Math.cos(pose.angle) * scale;
  const sin = Math.sin(pose.angle) * scale;
  context.setTransform(cos, -sin, -sin, -cos,
    (width / 2) * ratio + (pose.x - camera.x) * scale, (height / 2) * ratio - (pose.y - camera.y) * scale);
}
const toScreen = (view, x, y) => [view.width / 2 + (x - camera.x) * camera.scale, view.height / 2 - (y - camera.y) * camera.scale];
function toPixels(view) {
  view.context.setTransform(view.ratio, 0, 0, view.ratio, 0, 0);
}

function drawBody(view, figure, pose, stroke, fill, lineWidth) {
  place(view, pose);
  const { context } = view;
  context.lineWidth = lineWidth / camera.scale;
  context.strokeStyle = stroke;
  context.fillStyle = fill;
  for (const outline of figure.outlines) {
    context.globalAlpha = outline.isSensor ? 0.35 : 1;
    if (outline.isFilled && fill) context.fill(outline.path);
    context.stroke(outline.path);
  }
  context.globalAlpha = 1;
}

function drawGhosts(view, frame) {
  const at = ghosts.ticks.indexOf(track.ticks[frame]);
  if (at < 0) return;
  const pose = {};
  const own = {};
  const idOf = ghosts.ownIndex || (ghosts.ownIndex = ghosts.ids.map((id) => track.ids.indexOf(id)));
  for (let body = 0; body < ghosts.bodyCount(); ++body) {
    if (!ghosts.pose(body, at, 0, pose)) continue;
    const mine = idOf[body];
    if (mine >= 0 && track.pose(mine, frame, 0, own) && own.x === pose.x && own.y === pose.y && own.angle === pose.angle) continue;
    view.context.setLineDash([5 / camera.scale, 3 / camera.scale]);
    drawBody(view, figures[ghosts.figure[body]], pose, color('ghost'), null, 1.4);
  }
  view.context.setLineDash([]);
  toPixels(view);
}

function drawLabel(view, text, x, y, ink) {
  const { context } = view;
  context.font = font;
  context.lineJoin = 'round';
  context.lineWidth = 3;
  context.strokeStyle = color('panel');
  context.strokeText(text, x, y);
  context.fillStyle = ink;
  context.fillText(text, x, y);
}

const ringsMax = 16;

function drawRings(view, frame, share) {
  const pose = {};
  const bad = color('bad');
  for (const body of namedBodies) {
    if (!track.pose(body, frame, share, pose)) continue;
    drawBody(view, figures[track.figure[body]], pose, bad, null, 2.2);
    toPixels(view);
    if (namedBodies.length > ringsMax) continue;  // outlines are enough
    const [x, y] = toScreen(view, pose.x, pose.y);
    const radius = Math.max(figures[track.figure[body]].reach * camera.scale + 5, 13);
    view.context.strokeStyle = bad;
    view.context.lineWidth = 2;
    view.context.beginPath();
    view.context.arc(x, y, radius, 0, 2 * Math.PI);
    view.context.stroke();
    drawLabel(view, track.names[body], x + radius * 0.71 + 4, y - radius * 0.71 - 3, bad);
  }
}

let selected = -1;

function drawNames(view, frame, share) {
  const pose = {};
  const all = byId('names').checked;
  for (let body = 0; body < track.bodyCount(); ++body) {
    if (!(all && body !== selected) && body !== selected) continue;
    if (!track.pose(body, frame, share, pose)) continue;
    const [x, y] = toScreen(view, pose.x, pose.y);
    if (body === selected) {
      drawBody(view, figures[track.figure[body]], pose, color('accent'), null, 2.2);
      toPixels(view);
      const text = track.names[body] + '  id ' + track.ids[body] + '  (' + pose.x.toFixed(3) + ', ' + pose.y.toFixed(3) + ') m';
      drawLabel(view, text, clamp(x + 8, 8, Math.max(8, view.width - 240)), Math.max(y - 8, 14), color('ink'));
    } else if (x > -50 && y > -20 && x < view.width + 50 && y < view.height + 20) {
      drawLabel(view, track.names[body], x + 4, y - 4, color('quiet'));
    }
  }
}

function drawWorld() {
  const canvas = byId('world');
  const view = prepare(canvas);
  if (camera.isFitted) fitCamera(view.width, view.height);
  drawGrid(view.context, view.width, view.height);
  const { frame, share } = frameAt(player.at);
  const pose = {};
  for (const kind of ['static', 'kinematic', 'dynamic']) {
    const stroke = color(kind);
    const fill = color(kind + '-fill');
    for (let body = 0; body < track.bodyCount(); ++body) {
      const figure = figures[track.figure[body]];
      if (figure.type === kind && track.pose(body, frame, share, pose)) drawBody(view, figure, pose, stroke, fill, 1.2);
    }
  }
  toPixels(view);
  if (ghosts && byId('ghosts').checked && share === 0) drawGhosts(view, frame);
  const isBehind = focus !== null && player.at >= focus;
  if (isBehind) drawRings(view, frame, share);
  drawNames(view, frame, share);
  canvas.dataset.ringed = isBehind ? namedBodies.map((body) => track.names[body]).join('\n') : '';
  canvas.setAttribute('aria-label', count(track.bodyCount(), 'body').replace('bodys', 'bodies') + ', ' + clockText() +
    (isBehind && namedBodies.length > 0 ? ', ringed: ' + namedBodies.map((body) => track.names[body]).join(', ') : ''));
}

/** The body nearest to a point of the canvas, within its reach or 12 px. */
function bodyAt(x, y) {
  const view = { width: byId('world').clientWidth, height: byId('world').clientHeight };
  const { frame, share } = frameAt(player.at);
  const pose = {};
  let best = -1;
  let nearest = Infinity;
  for (let body = 0; body < track.bodyCount(); ++body) {
    const figure = figures[track.figure[body]];
    if (!track.pose(body, frame, share, pose)) continue;
    const [bx, by] = toScreen(view, pose.x, pose.y);
    const distance = Math.hypot(bx - x, by - y);
    if (distance > Math.max(figure.reach * camera.scale, 12)) continue;
    const size = distance / Math.max(figure.reach, 1e-9) + (figure.type === 'static' ? 1e6 : 0);
    if (size < nearest) { nearest = size; best = body; }
  }
  return best;
}
