// The timeline: how each tick compares, checkpoints, inputs, where the playback stands.

const stripColors = {
  same: 'strip-same',
  differs: 'strip-differs',
  differs_known: 'strip-differs',
  not_compared: 'strip-none',
  unread: 'strip-none',
  unread_intact: 'strip-warn',
  differs_other: 'strip-differs',
};
const isHatched = (match) => match === 'differs_known' || match === 'unread';
const margin = 12;

const xOfTick = (width, ticksDone) => margin + ((width - 2 * margin) * ticksDone) / Math.max(1, tickCount);
const tickOfX = (width, x) => clamp(Math.round(((x - margin) / Math.max(1, width - 2 * margin)) * tickCount), 0, tickCount);

/** Ticks in which the two traces differ are in both strips. What differs is drawn last and never thinner than two pixels: a single tick is seen. */
function drawStrip(context, strip, width, top, height) {
  const differs = (part) => (part[2] === 'differs_other' ? 1 : part[2] === 'differs' || part[2] === 'differs_known' ? 2 : 0);
  const others = data.against ? data.against.differing.map(([first, last]) => [first, last, 'differs_other']) : [];
  for (const [first, last, match] of [...strip, ...others].sort((a, b) => differs(a) - differs(b))) {
    const left = xOfTick(width, first);
    const size = Math.max(2, xOfTick(width, Math.min(last + 1, tickCount)) - left);
    context.fillStyle = color(stripColors[match]);
    context.fillRect(left, top, size, height);
    if (!isHatched(match)) continue;
    context.save();
    context.beginPath();
    context.rect(left, top, size, height);
    context.clip();
    context.strokeStyle = color('panel');
    context.lineWidth = 1.5;
    context.beginPath();
    for (let x = left - height; x < left + size; x += 5) {
      context.moveTo(x, top + height);
      context.lineTo(x + height, top);
    }
    context.stroke();
    context.restore();
  }
}

/** Ticks at round numbers with their labels. */
function drawTickLabels(context, width, y) {
  const step = niceStep(Math.max(1, (tickCount * 90) / Math.max(90, width)));
  context.font = font;
  context.fillStyle = color('quiet');
  context.textAlign = 'center';
  for (let tick = 0; tick <= tickCount; tick += step) {
    const x = xOfTick(width, tick);
    if (tick > 0 && x > width - 14) break;
    context.fillText(whole(tick), Math.max(x, 10), y);
  }
  context.textAlign = 'left';
}

function drawTimeline() {
  const { context, width, height } = prepare(byId('strip'));
  const top = 15;
  const hasOther = !!data.against;
  drawStrip(context, film.strip, width, top, hasOther ? 8 : 15);
  if (hasOther) drawStrip(context, data.against.strip, width, top + 9, 6);
  context.fillStyle = color('accent');
  const most = film.input_ticks.reduce((max, [, inputs]) => Math.max(max, inputs), 1);
  for (const [tick, inputs] of film.input_ticks) {
    const size = 3 + 8 * Math.sqrt(inputs / most);
    context.fillRect(xOfTick(width, tick + 0.5) - 0.5, top - 2 - size, 1, size);
  }
  context.fillStyle = color('ink');
  for (const tick of film.checkpoints) {
    const x = xOfTick(width, tick);
    context.beginPath();
    context.moveTo(x, top + 16.5);
    context.lineTo(x - 3, top + 21.5);
    context.lineTo(x + 3, top + 21.5);
    context.fill();
  }
  drawTickLabels(context, width, height - 8);
  if (focus !== null) {
    const x = Math.round(xOfTick(width, focus)) + 0.5;
    context.strokeStyle = color('bad');
    context.lineWidth = 1.5;
    context.beginPath();
    context.moveTo(x, 1);
    context.lineTo(x, top + 22);
    context.stroke();
  }
  const x = xOfTick(width, player.at);
  context.fillStyle = color('ink');
  context.fillRect(x - 1, top - 5, 2, 25);
  context.beginPath();
  context.arc(x, top - 6, 4.5, 0, 2 * Math.PI);
  context.fill();
}

function showLegend() {
  const legend = byId('legend');
  const key = (className, background, text) => {
    const mark = make('i', className);
    if (background) mark.style.backgroundColor = 'var(--' + background + ')';
    legend.append(make('span', '', mark, text));
  };
  const seen = new Set(film.strip.concat(data.against ? data.against.strip : []).map((part) => part[2]));
  if (seen.has('same')) key('', 'strip-same', 'tick as recorded');
  if (data.against && data.against.differing.length > 0) key('', 'strip-differs', 'the two traces differ');
  if (seen.has('differs')) key('', 'strip-differs', 'tick differs');
  if (seen.has('differs_known')) key('hatched', 'strip-differs', 'differs, recorded state known');
  if (seen.has('not_compared')) key('', 'strip-none', 'not compared');
  if (seen.has('unread')) key('hatched', 'strip-none', 'not in the file');
  if (seen.has('unread_intact')) key('', 'strip-warn', 'intact behind damage');
  if (data.against) legend.append(make('span', '', 'Upper strip: this trace; lower: the other'));
  if (ghosts) key('line-key', '', data.against ? 'body of the other trace' : 'body as it was recorded');
  if (namedBodies.length > 0) key('ring-key', '', 'body that is named');
  if (film.input_count > 0) legend.append(make('span', '', 'Bars: inputs'));
  if (film.checkpoints.length > 0) legend.append(make('span', '', 'Triangles: checkpoints'));
}

function playNote() {
  const parts = [];
  if (playback) {
    parts.push((data.against ? 'Both traces as they were recorded; where that is not known, as this build runs them.' :
      'A run of this build on the recorded inputs.') + ' Poses are drawn to ' + shortNumber(playback.grid.length * 1000) + ' mm.');
    if (playback.stride > 1)
      parts.push('One frame in ' + playback.stride + ' ticks, interpolated between' +
        (playback.exact ? '; every tick from ' + Math.max(0, playback.exact[0] - 1) + ' to ' + (playback.exact[1] - 1) : '') + '.');
    if (report.verdict === 'not_comparable') parts.push('This build is not the one that recorded the trace: it proves nothing about it.');
    if (data.against && !ghosts) parts.push('No body of the other trace is anywhere else at any of these ticks.');
    else if (ghosts && !data.against) parts.push('Ghosts are known from stored states and the hashes behind them.');
    else if (report.divergence) parts.push('What was recorded behind the divergence is not known: the trace stores hashes there.');
  }
  byId('play-note').textContent = parts.join(' ');
}
