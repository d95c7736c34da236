// Buttons, keys, fingers; light, dark and paper; the start of the page.

// --- hands --------------------------------------------------------------------------------------------------------

function listenToButtons() {
  byId('to-start').addEventListener('click', () => { pause(); seek(0); });
  byId('to-end').addEventListener('click', () => { pause(); seek(endOfTicks); });
  byId('back').addEventListener('click', () => step(-1));
  byId('forward').addEventListener('click', () => step(1));
  byId('toggle').addEventListener('click', () => (player.isPlaying ? pause() : play()));
  byId('to-focus').addEventListener('click', () => { pause(); seek(focus); });
  byId('speed').addEventListener('change', (event) => { player.speed = Number(event.target.value); });
  byId('ghosts').addEventListener('change', showPlace);
  byId('names').addEventListener('change', showPlace);
  byId('zoom-in').addEventListener('click', () => zoom(1.4));
  byId('zoom-out').addEventListener('click', () => zoom(1 / 1.4));
  byId('zoom-fit').addEventListener('click', fit);
}

function listenToKeys() {
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest('select, input, a')) return;
    if (event.target.closest('button, summary') && (event.key === ' ' || event.key === 'Enter')) return;
    const steps = event.shiftKey ? 10 : 1;
    const actions = {
      ' ': () => (player.isPlaying ? pause() : play()),
      ArrowLeft: () => step(-steps),
      ArrowRight: () => step(steps),
      Home: () => { pause(); seek(0); },
      End: () => { pause(); seek(endOfTicks); },
      d: () => { if (focus !== null) { pause(); seek(focus); } },
      '+': () => playback && zoom(1.4),
      '=': () => playback && zoom(1.4),
      '-': () => playback && zoom(1 / 1.4),
      0: () => playback && fit(),
      g: () => toggleBox('ghosts'),
      n: () => toggleBox('names'),
    };
    const scrolls = event.target.closest('.scroll') && ['Home', 'End', ' '].includes(event.key);
    if (!actions[event.key] || scrolls) return;
    event.preventDefault();
    actions[event.key]();
  });
}
function toggleBox(id) {
  byId(id).checked = !byId(id).checked;
  showPlace();
}

function listenToTimeline() {
  const timeline = byId('timeline');
  const go = (event) => seek(tickOfX(timeline.clientWidth, event.clientX - timeline.getBoundingClientRect().left));
  timeline.addEventListener('pointerdown', (event) => {
    timeline.setPointerCapture(event.pointerId);
    pause();
    go(event);
  });
  timeline.addEventListener('pointermove', (event) => { if (event.buttons) go(event); });
}

/** Drag moves, two fingers zoom, a click picks a body. */
function listenToWorld() {
  const canvas = byId('world');
  const fingers = new Map();
  let travelled = 0;
  const local = (event) => {
    const box = canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    if (fingers.size === 0) travelled = 0;
    fingers.set(event.pointerId, local(event));
  });
  canvas.addEventListener('pointermove', (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const now = local(event);
    travelled += Math.hypot(now.x - before.x, now.y - before.y);
    if (fingers.size === 2) {
      const other = [...fingers].find(([id]) => id !== event.pointerId)[1];
      const factor = Math.hypot(now.x - other.x, now.y - other.y) / Math.max(1, Math.hypot(before.x - other.x, before.y - other.y));
      zoom(factor, (now.x + other.x) / 2, (now.y + other.y) / 2);
    } else if (travelled > 4) {
      canvas.classList.add('is-dragged');
      setZoomed();
      camera.x -= (now.x - before.x) / camera.scale;
      camera.y += (now.y - before.y) / camera.scale;
      drawWorld();
    }
    fingers.set(event.pointerId, now);
  });
  const release = (event) => {
    canvas.classList.remove('is-dragged');
    if (fingers.delete(event.pointerId) && event.type === 'pointerup' && travelled <= 4) {
      const at = local(event);
      selected = bodyAt(at.x, at.y);
      drawWorld();
    }
  };
  canvas.addEventListener('pointerup', release);
  canvas.addEventListener('pointercancel', release);
  canvas.addEventListener('wheel', (event) => {
    if (!event.ctrlKey && document.activeElement !== canvas) return;  // else the page scrolls
    event.preventDefault();
    const at = local(event);
    zoom(Math.exp(-event.deltaY * (event.ctrlKey ? 0.01 : 0.0015)), at.x, at.y);
  }, { passive: false });
}

// --- light, dark, paper, size -------------------------------------------------------------------------------------

function redraw() {
  style = getComputedStyle(document.documentElement);
  for (const plot of plots) plot.picture = null;
  if (film && tickCount > 0) showPlace();
}

function listenToTheme() {
  const dark = window.matchMedia('(prefers-color-scheme: dark)');
  const isDark = () => (document.documentElement.dataset.theme || (dark.matches ? 'dark' : 'light')) === 'dark';
  const label = () => { byId('theme').textContent = isDark() ? 'Light' : 'Dark'; };
  byId('theme').addEventListener('click', () => {
    document.documentElement.dataset.theme = isDark() ? 'light' : 'dark';
    label();
    redraw();
  });
  dark.addEventListener('change', () => { label(); redraw(); });
  label();
  const paper = window.matchMedia('print');
  const print = (begins) => {
    isPrinting = begins;
    redraw();
  };
  paper.addEventListener('change', (event) => print(event.matches));
  window.addEventListener('beforeprint', () => print(true));
  window.addEventListener('afterprint', () => print(false));
}

/** As high as the view asks for, within what a screen shows beside the timeline. */
function setStageHeight() {
  if (!playback) return;
  const [left, bottom, right, top] = playback.view;
  const width = byId('stage').clientWidth;
  const wanted = (width * (top - bottom)) / (right - left);
  byId('world').style.height = Math.round(clamp(wanted, 240, Math.max(260, Math.min(560, window.innerHeight * 0.62)))) + 'px';
}

function showPlayback() {
  if (!film || tickCount === 0) return;
  byId('play').hidden = false;
  byId('timeline').setAttribute('aria-valuemax', String(endOfTicks));
  if (film.no_poses) {
    byId('no-poses').hidden = false;
    byId('no-poses').textContent = 'No playback. ' + film.no_poses;
  }
  if (!playback) {
    byId('stage').hidden = true;
    byId('timeline').classList.add('alone');
    for (const id of ['toggle', 'speed', 'names']) byId(id).closest('label, button').hidden = true;
  } else {
    readFigures();
  }
  if (focus !== null && focus <= endOfTicks) {
    byId('to-focus').hidden = false;
    byId('to-focus').textContent = 'Go to tick ' + focusTick();
    byId('to-focus').setAttribute('aria-label', 'To tick ' + focusTick() + ', where it differs');
  }
  byId('ghosts-label').hidden = !ghosts;
  showLegend();
  playNote();
}

// --- start --------------------------------------------------------------------------------------------------------

byId('text-details').open = false;
byId('keys').hidden = !film;
showVerdict();
showWhere();
showAgainst();
showNext();
showOthers();
showAbout();
showPlayback();
showInputs();
showPlots();
listenToTheme();
if (film && tickCount > 0) {
  listenToButtons();
  listenToKeys();
  listenToTimeline();
  if (playback) listenToWorld();
  setStageHeight();
  const asked = /tick=(\d+)/.exec(window.location.hash);  // page.html#tick=200: the state at the end of that tick
  seek(asked ? Number(asked[1]) + 1 : focus !== null && focus <= endOfTicks ? focus : 0);
  window.addEventListener('resize', () => { setStageHeight(); redraw(); });
}

// What tests and curious people may ask.
window.ticktrue = {
  data, seek, play, pause,
  state: () => ({
    ticksDone: player.at, isPlaying: player.isPlaying, ringed: byId('world').dataset.ringed || '', pixelsPerMetre: camera.scale,
  }),
  pose: (name) => {
    const pose = {};
    const { frame, share } = frameAt(player.at);
    return track.pose(track.names.indexOf(name), frame, share, pose) ? pose : null;
  },
};
