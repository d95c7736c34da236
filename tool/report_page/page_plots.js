// Plots over ticks.

const plots = [];

/** `series`: [{label, values, color, isThin}]; one value for each frame. */
function addPlot(title, unit, series, options) {
  const canvas = make('canvas');
  canvas.setAttribute('role', 'img');
  const values = make('span', 'values');
  const figure = make('figure', 'plot', make('figcaption', '', make('span', 'title', title + (unit ? ', ' + unit : '')), values), canvas);
  byId('plot-list').append(figure);
  const plot = { canvas, values, series, unit, isLog: false, missing: 'not finite', ...options, picture: null };
  setRange(plot);
  canvas.setAttribute('aria-label', title + ' over ticks, from ' + shortNumber(plot.low) + ' to ' + shortNumber(plot.high) + ' ' + unit);
  canvas.addEventListener('pointerdown', (event) => { pause(); seek(tickOfPlot(plot, event)); });
  canvas.addEventListener('pointermove', (event) => { if (event.buttons) seek(tickOfPlot(plot, event)); });
  plots.push(plot);
}

function setRange(plot) {
  let low = Infinity;
  let high = -Infinity;
  for (const { values } of plot.series)
    for (const value of values) {
      if (!Number.isFinite(value) || (plot.isLog && value <= 0)) continue;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  plot.isEmpty = !(low <= high);
  if (plot.isEmpty) [low, high] = plot.isLog ? [1e-9, 1] : [0, 1];
  if (plot.isLog) {
    low = Math.max(low, 1e-18);
    const first = Math.floor(Math.log10(low));
    [low, high] = [10 ** first, 10 ** Math.max(first + 1, Math.ceil(Math.log10(high)))];
  } else {
    if (low > 0) low = 0;
    if (high < 0) high = 0;
    if (high === low) high = low + 1;
  }
  plot.low = low;
  plot.high = high;
}

const plotLeft = 58;
const plotRight = 8;
const plotTop = 6;
const plotBottom = 17;
const xOfPlot = (width, ticksDone) => plotLeft + ((width - plotLeft - plotRight) * ticksDone) / Math.max(1, tickCount);
function tickOfPlot(plot, event) {
  const width = plot.canvas.clientWidth;
  const share = (event.clientX - plot.canvas.getBoundingClientRect().left - plotLeft) / (width - plotLeft - plotRight);
  return clamp(Math.round(share * tickCount), 0, tickCount);
}
function yOfPlot(plot, height, value) {
  const size = height - plotTop - plotBottom;
  const share = plot.isLog
    ? Math.log(Math.max(value, plot.low) / plot.low) / Math.log(plot.high / plot.low)
    : (value - plot.low) / (plot.high - plot.low);
  return plotTop + size * (1 - share);
}

function plotTicks(plot) {
  if (plot.isLog) {
    const first = Math.round(Math.log10(plot.low));
    const last = Math.round(Math.log10(plot.high));
    const step = Math.ceil((last - first) / 4);
    const ticks = [];
    for (let power = first; power <= last; power += step) ticks.push(10 ** power);
    return ticks;
  }
  const step = niceStep((plot.high - plot.low) / 4);
  const ticks = [];
  for (let i = Math.ceil(plot.low / step); i * step <= plot.high * 1.0001; ++i) ticks.push(i * step);
  return ticks;
}

/** Lowest and highest value in each pixel column, so that no peak is lost. */
function drawSeries(plot, context, width, height, series) {
  context.strokeStyle = color(series.color);
  context.lineWidth = series.isThin ? 1 : 1.5;
  context.setLineDash(series.isThin ? [4, 3] : []);
  context.beginPath();
  let isDown = false;
  const ticks = track.ticks;
  for (let i = 0; i < ticks.length;) {
    const column = Math.round(xOfPlot(width, ticks[i]));
    let low = Infinity, high = -Infinity, first = NaN, last = NaN;
    for (; i < ticks.length && Math.round(xOfPlot(width, ticks[i])) === column; ++i) {
      const value = series.values[i];
      if (!Number.isFinite(value)) continue;
      if (Number.isNaN(first)) first = value;
      last = value;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
    if (Number.isNaN(first)) { isDown = false; continue; }
    for (const value of low === high ? [first] : [first, low, high, last]) {
      const y = yOfPlot(plot, height, value);
      if (isDown) context.lineTo(column, y);
      else context.moveTo(column, y);
      isDown = true;
    }
  }
  context.stroke();
  context.setLineDash([]);
}

function drawPlotPicture(plot) {
  const { context, width, height } = prepare(plot.canvas);
  if (plot.canvas.width === 0) return;  // not laid out yet
  context.font = font;
  context.textAlign = 'right';
  context.lineWidth = 1;
  for (const value of plotTicks(plot)) {
    const y = Math.round(yOfPlot(plot, height, value)) + 0.5;
    context.strokeStyle = color(value === 0 && !plot.isLog ? 'line-strong' : 'line');
    context.beginPath();
    context.moveTo(plotLeft, y);
    context.lineTo(width - plotRight, y);
    context.stroke();
    context.fillStyle = color('quiet');
    context.fillText(shortNumber(value), plotLeft - 6, y + 3.5);
  }
  context.textAlign = 'center';
  const step = niceStep(Math.max(1, (tickCount * 80) / Math.max(80, width - plotLeft)));
  for (let tick = 0; tick <= tickCount; tick += step) {
    const x = xOfPlot(width, tick);
    if (x < width - 12) context.fillText(whole(tick), x, height - 4);
  }
  context.textAlign = 'left';
  if (focus !== null) {
    const x = Math.round(xOfPlot(width, focus)) + 0.5;
    context.strokeStyle = color('bad');
    context.globalAlpha = 0.55;
    context.beginPath();
    context.moveTo(x, plotTop);
    context.lineTo(x, height - plotBottom);
    context.stroke();
    context.globalAlpha = 1;
  }
  for (const series of plot.series) drawSeries(plot, context, width, height, series);
  if (plot.isEmpty) {
    context.fillStyle = color('quiet');
    context.fillText(plot.isLog ? 'no difference above 0' : 'nothing to show', plotLeft + 10, height / 2);
  }
  if (!plot.picture) plot.picture = document.createElement('canvas');
  plot.picture.width = plot.canvas.width;
  plot.picture.height = plot.canvas.height;
  plot.picture.getContext('2d').drawImage(plot.canvas, 0, 0);
}

function drawPlots() {
  if (plots.length === 0) return;
  const { frame } = frameAt(player.at);
  for (const plot of plots) {
    const { context, width, height, ratio } = prepare(plot.canvas);
    if (!plot.picture || plot.picture.width !== plot.canvas.width) drawPlotPicture(plot);
    if (!plot.picture) continue;
    context.clearRect(0, 0, width, height);
    context.drawImage(plot.picture, 0, 0, plot.picture.width / ratio, plot.picture.height / ratio);
    const x = Math.round(xOfPlot(width, player.at)) + 0.5;
    context.strokeStyle = color('ink');
    context.lineWidth = 1;
    context.beginPath();
    context.moveTo(x, plotTop);
    context.lineTo(x, height - plotBottom);
    context.stroke();
    plot.values.replaceChildren(...plot.series.flatMap((series, i) => {
      const value = series.values[frame];
      const text = make('b', '', Number.isFinite(value) ? shortNumber(value) : plot.missing);
      text.style.color = 'var(--' + series.color + ')';
      return [i > 0 ? ', ' : '', series.label ? series.label + ' ' : '', text];
    }), plot.detail ? plot.detail(frame) : '');
  }
}

function inputsPerFrame() {
  const values = new Float32Array(track.ticks.length);
  for (const [tick, inputs] of film.input_ticks) {
    const frame = lastIndexBelow(track.ticks, tick);
    values[Math.min(frame + 1, values.length - 1)] += inputs;
  }
  return values;
}

function showPlots() {
  if (!playback || track.ticks.length < 2) return;
  byId('plots').hidden = false;
  const sums = {};
  for (const [name, text] of Object.entries(playback.sums)) sums[name] = floatsOf(text);
  const total = sums.kinetic.map((value, i) => value + sums.potential[i]);
  addPlot('Energy', 'J', [
    { label: 'kinetic', values: sums.kinetic, color: 'series-1' },
    { label: 'potential', values: sums.potential, color: 'series-3' },
    { label: 'sum', values: total, color: 'series-2' }]);
  addPlot('Momentum', 'kg m/s', [
    { label: 'x', values: sums.momentum_x, color: 'series-1' },
    { label: 'y', values: sums.momentum_y, color: 'series-2' }]);
  addPlot('Deepest penetration', 'mm', [{ label: '', values: sums.penetration.map((value) => value * 1000), color: 'series-1' }],
    { detail: (frame) => ' of ' + count(sums.contacts[frame], 'contact') });
  if (playback.drift) {
    const furthest = floatsOf(playback.drift.body);
    addPlot(data.against ? 'Drift from the other trace' : 'Drift from the recording', 'm',
      [{ label: '', values: floatsOf(playback.drift.distance), color: 'series-2' }],
      { isLog: true, missing: 'not known', detail: (frame) => (furthest[frame] >= 0 ? ' ' + track.names[furthest[frame]] : '') });
  }
  if (film.input_count > 0)
    addPlot('Inputs', playback.stride > 1 ? 'per frame' : 'per tick', [{ label: '', values: inputsPerFrame(), color: 'series-1' }]);
  byId('plot-list').dataset.count = String(plots.length);
}
