// Which tick is shown, and how it moves on.

// Ticks done in the state that is shown. Whole, unless it lies between two frames of a thinned playback.
const player = { at: 0, isPlaying: false, speed: 1, clock: 0, last: 0, stopAt: null };
const endOfTicks = playback ? track.ticks[track.ticks.length - 1] : tickCount;
const shownTicks = () => Math.floor(player.at + 1e-9);

/** Frame at or before the place, and how far it is to the next one. */
function frameAt(at) {
  const frame = lastIndexBelow(track.ticks, at);
  const next = track.ticks[frame + 1];
  const share = next === undefined ? 0 : (at - track.ticks[frame]) / (next - track.ticks[frame]);
  return { frame, share: clamp(share, 0, 1) };
}

function timeAt(at) {
  const { frame, share } = frameAt(at);
  return share > 0 ? times[frame] + (times[frame + 1] - times[frame]) * share : times[frame];
}

// Against another trace, what was recorded is shown wherever it is known; else this build's run.
const matchWords = {
  same: 'as recorded',
  differs: 'not as recorded',
  differs_known: data.against ? 'as recorded, from a stored state' : 'not as recorded',
  not_compared: 'not compared',
  unread: 'not in the file any more',
  unread_intact: 'intact, but behind damage',
};
function matchAt(strip, ticksDone) {
  if (ticksDone === 0) return 'same';
  const part = strip.find((one) => ticksDone - 1 >= one[0] && ticksDone - 1 <= one[1]);
  return part ? part[2] : 'not_compared';
}

const matchText = (ticksDone) => matchWords[matchAt(film.strip, ticksDone)];

function clockText() {
  const ticks = shownTicks();
  const where = ticks === 0 ? 'start' : 'tick ' + (ticks - 1);
  const time = playback ? dot + timeAt(player.at).toFixed(3) + ' s' : '';
  const between = playback && frameAt(player.at).share > 0 ? dot + 'interpolated' : '';
  return where + ' of ' + tickCount + time + between;
}

function seek(at) {
  player.at = clamp(at, 0, endOfTicks);
  if (playback) player.clock = timeAt(player.at);
  showPlace();
}

function showPlace() {
  const ticks = shownTicks();
  byId('clock').textContent = clockText() + dot + matchText(ticks);
  const slider = byId('timeline');
  slider.setAttribute('aria-valuenow', String(ticks));
  slider.setAttribute('aria-valuetext', clockText() + ', ' + matchText(ticks));
  const isBehind = focus !== null && ticks >= focus;
  byId('stage-note').textContent = isBehind && playback ? focusNote() : '';
  drawTimeline();
  if (playback) drawWorld();
  drawPlots();
  markInputRows();
}

function focusNote() {
  const names = namedBodies.map((body) => track.names[body]);
  const shown = names.slice(0, 4).join(', ') + (names.length > 4 ? ' and ' + (names.length - 4) + ' more' : '');
  const what = report.divergence ? 'First differs from the recording' : 'First differs from the other trace';
  return what + ' at tick ' + focusTick() + (shown ? ': ' + shown : '');
}
function focusTick() {
  const divergence = report.divergence || (data.against && data.against.diff.divergence);
  return divergence ? divergence.tick : Math.max(0, focus - 1);
}

function step(direction) {
  pause();
  if (!playback) return seek(shownTicks() + direction);
  const frame = lastIndexBelow(track.ticks, player.at);
  const isBetween = track.ticks[frame] < player.at;
  const next = direction > 0 ? frame + direction : frame + direction + (isBetween ? 1 : 0);
  seek(track.ticks[clamp(next, 0, track.ticks.length - 1)]);
}

function play() {
  if (!playback) return;
  if (player.at >= endOfTicks) player.at = 0;
  player.isPlaying = true;
  player.stopAt = focus !== null && player.at < focus ? focus : null;
  player.clock = timeAt(player.at);
  player.last = performance.now();
  showToggle();
  requestAnimationFrame(advance);
}
function pause() {
  player.isPlaying = false;
  showToggle();
}
function showToggle() {
  byId('toggle').setAttribute('aria-label', player.isPlaying ? 'Pause' : 'Play');
  byId('toggle-icon').setAttribute('d', player.isPlaying ? 'M4 2.5h3v11H4zM9 2.5h3v11H9z' : 'M4 2.5l9 5.5-9 5.5z');
}

function advance(now) {
  if (!player.isPlaying) return;
  player.clock += (clamp(now - player.last, 0, 250) / 1000) * player.speed;
  player.last = now;
  const frame = lastIndexBelow(times, player.clock);
  let at = track.ticks[frame];
  const next = track.ticks[frame + 1];
  if (next !== undefined && next > at + 1)  // frames are missing here: between two of them
    at += clamp((player.clock - times[frame]) / (times[frame + 1] - times[frame]), 0, 1) * (next - at);
  const ends = frame === track.ticks.length - 1;
  const stops = player.stopAt !== null && at >= player.stopAt;
  if (stops) at = Math.min(player.stopAt, endOfTicks);
  player.at = at;
  if (stops || ends) pause();
  showPlace();
  if (stops) byId('announce').textContent = 'Stopped: ' + focusNote();
  if (player.isPlaying) requestAnimationFrame(advance);
}
