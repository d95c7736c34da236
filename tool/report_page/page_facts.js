// The facts of the report as text and tables. Everything that comes from a trace is put on the page as text.

// --- facts --------------------------------------------------------------------------------------------------------

const verdictWords = {
  match: ['Match', 'good'],
  diverged: ['Diverged', 'bad'],
  state_incomplete: ['State incomplete', 'bad'],
  not_reproducible: ['Not reproducible', 'bad'],
  damaged: ['Damaged', 'warn'],
  incomplete: ['Incomplete', 'warn'],
  not_comparable: ['Not comparable', 'warn'],
  error: ['Error', 'bad'],
  equal: ['Equal', 'good'],
  different: ['Different', 'bad'],
};
const verdictOf = (name) => verdictWords[name] || [name, 'warn'];

function addFact(list, label, value, path) {
  const content = make('dd', '', value);
  if (path) fact(content, path);
  list.append(make('div', '', make('dt', '', label), content));
}

/** A labelled line; `value` is text or an element, or several. */
function addLine(list, label, values, path) {
  const all = Array.isArray(values) ? values : [values];
  if (all.length === 0) return;
  list.append(make('dt', '', label));
  all.forEach((value, i) => {
    const line = make('dd', '', value);
    if (path && i === 0) fact(line, path);
    list.append(line);
  });
}

const mono = (text) => make('span', 'mono', text);
const hex = (text, className) => make('span', 'hex ' + (className || ''), text);

function showVerdict() {
  const { verdict, sentence, summary } = data.headline;
  const [word, tone] = verdictOf(verdict);
  byId('file').textContent = report.file;
  const section = byId('verdict');
  section.dataset.tone = tone;
  section.hidden = false;
  const name = byId('verdict-name');
  name.dataset.value = verdict;
  name.textContent = word;
  if (verdict === report.verdict) fact(name, 'verdict');
  byId('sentence').textContent = capital(sentence);
  byId('summary').textContent = sentence === summary ? '' : capital(summary) + '.';
  const facts = byId('facts');
  if (report.title) addFact(facts, 'Scene', report.title, 'title');
  const of = report.ticks_recorded === null ? '' : ' of ' + whole(report.ticks_recorded);
  addFact(facts, 'Ticks compared', whole(report.ticks_compared) + of, 'ticks_compared');
  addFact(facts, 'Simulated', seconds(report.time_s), 'time_s');
  if (report.checkpoint !== null) addFact(facts, 'Differs from checkpoint', 'tick ' + whole(report.checkpoint));
  addFact(facts, 'Checkpoints compared', whole(report.checkpoints_compared), 'checkpoints_compared');
  if (report.ticks_compared > 0) addFact(facts, 'Last equal state', hex(report.root_hash), 'root_hash');
  showNotices();
}

function notice(text, isPlain) {
  byId('notices').append(make('p', 'notice' + (isPlain ? ' plain-notice' : ''), text));
}

function showNotices() {
  const comparesOnly = data.against && report.verdict === 'not_comparable';
  if (comparesOnly) {
    notice('The two traces are compared as recorded; nothing was run here: ' + report.reason + '.', true);
    return;
  }
  if (data.headline.verdict !== report.verdict)
    notice('This trace alone: ' + verdictOf(report.verdict)[0].toLowerCase() + '.', true);
  if (report.reason && !data.headline.sentence.includes(report.reason)) notice(report.reason);
  const end = report.end;
  if (end && end.condition !== 'complete') {
    const proven = end.ticks_intact > 0 ? 'Ticks 0 to ' + whole(end.ticks_intact - 1) + ' are intact.' : 'No tick is intact.';
    notice((end.condition === 'damaged' ? 'The file is damaged: ' : 'The file ends early: ') + end.message + '. ' + proven);
  }
  for (const range of report.intact_after || [])
    notice('Behind the damage, ticks ' + whole(range.first_tick) + ' to ' + whole(range.last_tick) + ' are intact' +
           (range.has_checkpoint ? ', with a checkpoint.' : '.'));
  if (report.non_finite) {
    const at = report.non_finite;
    notice('Not finite at tick ' + at.tick + ': ' + at.table + '.' + at.column + ', row ' + at.row +
           (at.name ? ' (' + at.name + ')' : '') + ', lane ' + at.lane + ' is ' + at.value + '.');
  }
  for (const warning of report.warnings) notice(warning);
  for (const note of report.notes) notice(note, true);
  if (film && film.stopped && !report.non_finite) notice('The run here ended early: ' + film.stopped + '.');
}

function rowName(row) {
  let text = row.place || row.table + ' row ' + row.row;
  if (row.id !== null && row.id !== undefined) text += ', id ' + row.id;
  return row.name ? [make('b', '', row.name), make('span', 'quiet', '  ' + text)] : [text];
}

function table(heads, rows) {
  const head = make('tr');
  for (const [text, className] of heads) head.append(make('th', className || '', text));
  const body = make('tbody');
  for (const row of rows) body.append(row);
  const box = make('div', 'table-box scroll', make('table', '', make('thead', '', head), body));
  box.tabIndex = 0;
  return box;
}

function value(bits, number, className) {
  if (bits === null) return make('td', '', 'no such row');
  const shown = Object.is(number, -0) ? '-0' : number;
  return make('td', '', hex(bits, className), make('span', 'quiet', '  ' + shown));
}

/** The lanes that differ, with both sides. */
function laneTable(divergence, path, sides) {
  return table(
    [['Column'], ['Row'], [sides[0]], [sides[1]], ['ulp', 'num']],
    divergence.rows.map((row, i) => {
      const at = path + '.rows.' + i + '.';
      const lane = divergence.rows.some((other) => other.column === row.column && other.lane > 0) || row.lane > 0;
      const expected = value(row.expected, row.expected_value, 'side-expected');
      const got = value(row.got, row.got_value, 'side-got');
      if (row.expected !== null) fact(expected.firstChild, at + 'expected');
      if (row.got !== null) fact(got.firstChild, at + 'got');
      return make('tr', '',
        make('td', '', fact(make('span', '', row.table + '.' + row.column), at + 'column'),
          lane ? make('span', 'quiet', '  lane ' + row.lane) : ''),
        fact(make('td', '', ...rowName(row)), at + 'name'), expected, got,
        fact(make('td', 'num', row.ulp === null ? '' : whole(row.ulp)), at + 'ulp'));
    }));
}

/** What could end a line or turn the direction of text, as escapes. */
function quoted(text) {
  const escaped = (c) => '\\u' + c.charCodeAt(0).toString(16).padStart(4, '0');
  return JSON.stringify(text).replace(/[\u007f-\u009f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]/g, escaped);
}

/** The texts and strings of bytes that differ, with both sides. */
function contentTable(divergence, path, sides) {
  const side = (content, bytes) => bytes === null ? 'no such row' :
    content.kind === 'text' ? (content.first > 0 ? '...' : '') + quoted(bytes) : mono(bytes || 'nothing');
  return table(
    [['Text'], [sides[0]], [sides[1]], ['differs at']],
    divergence.contents.map((content, i) => {
      const at = path + '.contents.' + i + '.';
      const id = content.id === null ? '' : make('span', 'quiet', '  id ' + content.id);
      const place = content.character === null ? 'byte ' + whole(content.byte) : 'character ' + whole(content.character);
      return make('tr', '',
        fact(make('td', '', make('span', '', content.place), id), at + 'place'),
        fact(make('td', '', side(content, content.expected)), at + 'expected'),
        fact(make('td', '', side(content, content.got)), at + 'got'),
        fact(make('td', '', place), at + 'byte'));
    }));
}

function candidateTable(cells, path) {
  return table([['Rows that can have differed'], ['id', 'num']], cells.candidates.map((row, i) =>
    make('tr', '',
      fact(make('td', '', ...rowName({ ...row, id: null })), path + '.cells.candidates.' + i + '.name'),
      make('td', 'num', row.id === null ? '' : String(row.id)))));
}

function spreadText(divergence) {
  return divergence.spread.map((at) =>
    'tick ' + whole(at.tick) + ': ' + (at.rows === 0 ? 'none' : at.rows === at.of ? 'all ' + whole(at.of) :
      (at.estimated && at.rows > 4 ? 'about ' : '') + whole(at.rows) + ' of ' + whole(at.of))).join('; ');
}

const inputsShownMax = 20;

function showDivergence(divergence, path, sides, lines, tables) {
  addLine(lines, 'Tick', make('span', '', fact(make('b', '', whole(divergence.tick)), path + '.tick'),
    make('span', 'quiet', '  began at '), fact(make('span', '', seconds(divergence.time_s)), path + '.time_s')));
  if (divergence.stage || divergence.stage_note)
    addLine(lines, 'Stage', make('span', '', divergence.stage ? make('b', '', divergence.stage) : '',
      make('span', 'quiet', (divergence.stage ? '  ' : '') + divergence.stage_note)), path + '.stage');
  const columns = divergence.tables.map((part) =>
    part.content ? part.table : part.columns.map((column) => part.table + '.' + column).join(', '));
  addLine(lines, 'Columns', columns.length > 0 ? columns : 'not known: the trace stores only a hash of this tick',
    path + '.columns');
  const [one, two] = [sides[0].toLowerCase(), sides[1].toLowerCase()];
  const cells = divergence.cells;
  if (cells) {
    addLine(lines, 'Rows', whole(cells.candidate_count) + ' of ' + count(cells.rows, 'row') +
      ' can have differed, with the rows that refer to them' +
      (cells.unexplained_cells > 0 ?
        '; ' + count(cells.unexplained_cells, 'cell') + ' belong to a row that is not there' : ''));
    for (const part of cells.row_counts)
      addLine(lines, 'Row count', part.table + ': ' + one + ' ' + part.expected + ', ' + two + ' ' + part.got);
  }
  if (divergence.expected_hash !== divergence.got_hash)
    addLine(lines, 'State hash', make('span', '', one + ' ', hex(divergence.expected_hash, 'side-expected'),
      ', ' + two + ' ', hex(divergence.got_hash, 'side-got')), path + '.hash');
  const inputs = divergence.inputs.slice(0, inputsShownMax).map((line) => mono(line));
  if (divergence.inputs.length > inputsShownMax)
    inputs.push('and ' + count(divergence.inputs.length - inputsShownMax, 'more input'));
  addLine(lines, 'Inputs', inputs.length > 0 ? inputs : 'none at this tick', path + '.inputs');
  if (divergence.spread.length > 0) addLine(lines, 'Spread', spreadText(divergence));
  if (divergence.rows.length > 0) tables.append(laneTable(divergence, path, sides));
  if (divergence.lane_count > divergence.rows.length)
    tables.append(make('p', 'quiet small', 'and ' + count(divergence.lane_count - divergence.rows.length, 'more lane')));
  const contents = divergence.contents || [];
  if (contents.length > 0) tables.append(contentTable(divergence, path, sides));
  if (divergence.content_count > contents.length)
    tables.append(make('p', 'quiet small', 'and ' + count(divergence.content_count - contents.length, 'more text')));
  if (cells && divergence.rows.length === 0 && cells.candidates.length > 0) tables.append(candidateTable(cells, path));
}

/** What the values look like, and the facts of the two programs that differ. */
function showWhy(why, differences, keys, names, path, lines) {
  if (why) addLine(lines, 'Why', why.map((cause, i) => (i > 0 ? 'or ' : '') + cause.text), path + '.why');
  if (differences)
    addLine(lines, 'Builds differ', differences.map((one) =>
      one.name + ': ' + names[0] + ' ' + one[keys[0]] + ', ' + names[1] + ' ' + one[keys[1]] +
        (one.changes_bits ? ' (changes bits)' : '')));
}

function showWhere() {
  if (!report.divergence) return;
  byId('where').hidden = false;
  const sides = report.against && report.against.diverged_at !== null ? ['There', 'Here'] : ['Expected', 'Got'];
  showDivergence(report.divergence, 'divergence', sides, byId('where-lines'), byId('where-tables'));
  showWhy(report.why, report.builds.differ, ['recorded', 'here'], ['recorded', 'here'], 'divergence', byId('where-lines'));
}

function otherMatch() {
  const first = data.against.strip.find((part) => part[2] === 'differs' || part[2] === 'differs_known');
  if (first) return 'it first differs from its own recording at tick ' + whole(first[0]);
  const same = data.against.strip.filter((part) => part[2] === 'same').reduce((sum, part) => sum + part[1] - part[0] + 1, 0);
  return same > 0 ? 'it matches its own recording at ' + count(same, 'tick') : 'it was not run here';
}

function showAgainst() {
  const against = data.against;
  if (!against) return;
  byId('against').hidden = false;
  const lines = byId('against-lines');
  const diff = against.diff;
  const [word, tone] = verdictOf(diff.verdict);
  const chip = make('span', '', fact(make('span', 'chip', word), 'diff.verdict'));
  chip.dataset.tone = tone;
  addLine(lines, 'Verdict', make('span', '', chip, '  ' + (diff.reason || count(diff.ticks_compared, 'tick') + ' compared')));
  addLine(lines, 'Other trace', mono(against.trace.file));
  addLine(lines, 'Run by this build', otherMatch());
  addLine(lines, 'Setup', diff.setup.map((part) => part.what + ': ' + part.a + ' in this one, ' + part.b + ' in the other'));
  if (diff.inputs)
    addLine(lines, 'First other input', ['tick ' + whole(diff.inputs.tick),
      ...diff.inputs.inputs_a.slice(0, 8).map((line) => mono('this:  ' + line)),
      ...diff.inputs.inputs_b.slice(0, 8).map((line) => mono('other: ' + line))]);
  addLine(lines, 'Notes', diff.notes);
  if (against.no_poses) addLine(lines, 'Ghosts', 'none. ' + against.no_poses);
  if (diff.divergence) showDivergence(diff.divergence, 'diff.divergence', ['This', 'Other'], lines, byId('against-tables'));
  showWhy(diff.why, diff.build_differences, ['a', 'b'], ['this', 'other'], 'diff', lines);
}

function copyButton(text) {
  const button = make('button', '', 'Copy');
  button.type = 'button';
  button.setAttribute('aria-label', 'Copy the command');
  button.addEventListener('click', () => {
    const done = () => { button.textContent = 'Copied'; setTimeout(() => { button.textContent = 'Copy'; }, 1500); };
    if (navigator.clipboard) navigator.clipboard.writeText(text).then(done, () => selectText(button.previousSibling));
    else selectText(button.previousSibling);
  });
  return button;
}
function selectText(element) {
  const range = document.createRange();
  range.selectNodeContents(element);
  const selection = window.getSelection();
  selection.removeAllRanges();
  selection.addRange(range);
}

function showNext() {
  const commands = report.again.concat(data.against ? data.against.diff.again : []);
  if (commands.length === 0 && !report.hint) return;
  byId('next').hidden = false;
  const box = byId('next-lines');
  if (report.hint) box.append(make('p', '', capital(report.hint) + '.'));
  commands.forEach((command, i) =>
    box.append(make('div', 'command', fact(make('code', '', command), 'again.' + i), copyButton(command))));
}

function showOthers() {
  if (data.others.length === 0) return;
  byId('others').hidden = false;
  const body = byId('others-table').tBodies[0];
  for (const other of data.others) {
    const [word, tone] = verdictOf(other.verdict);
    const cell = make('td', '', make('span', 'chip', word));
    cell.dataset.tone = tone;
    body.append(make('tr', '', cell, make('td', 'mono', other.file), make('td', '', other.sentence)));
  }
  const left = data.other_count - data.others.length;
  if (left > 0) body.append(make('tr', '', make('td'), make('td', '', 'and ' + count(left, 'more trace')), make('td')));
}

function factsText(facts) {
  return Object.entries(facts).filter(([, text]) => text).map(([name, text]) => name + ' ' + text).join(', ');
}

function showAbout() {
  byId('about').hidden = false;
  const lines = byId('about-lines');
  const trace = data.trace;
  addLine(lines, 'File', mono(report.file));
  if (trace) {
    addLine(lines, 'Size', count(trace.size, 'byte') + ', ' + count(tickCount, 'tick') + ', detail ' + trace.detail);
    addLine(lines, 'Simulation', trace.simulation + ', physics version ' + trace.physics_version);
    addLine(lines, 'Tick', shortNumber(trace.dt) + ' s, unless a tick says otherwise');
    addLine(lines, 'Checkpoints', count(film.checkpoint_count, 'checkpoint') +
      (trace.checkpoint_interval > 0 ? ', every ' + count(trace.checkpoint_interval, 'tick') : ''));
  }
  if (report.end) {
    const reason = report.end.reason === 'complete' ? '' : report.end.reason;
    addLine(lines, 'End', [report.end.condition, reason, report.end.note].filter(Boolean).join(', '));
  }
  const recorded = factsText(report.builds.recorded);
  if (recorded) addLine(lines, 'Recorded by', recorded);
  addLine(lines, 'Verified by', factsText(report.builds.here));
  const other = report.against;
  if (other)
    addLine(lines, 'Other build', other.binary + ': ' + (other.verdict || other.reason) + ', ' + factsText(other.build));
  addLine(lines, 'Mode', report.mode || 'none');
  byId('footer').textContent = 'Made by: ' + data.command + '  -  ' + data.made_by;
}

// --- inputs -------------------------------------------------------------------------------------------------------

function inputRow(tick, line) {
  let player = '', kind = '', rest = line;
  try {
    const fields = JSON.parse(line);
    const names = Object.keys(fields).filter((name) => !['tick', 'player', 'kind', 'type'].includes(name));
    player = fields.player === undefined ? '' : String(fields.player);
    kind = String(fields.kind || fields.type || '');
    rest = names.map((name) => name + ' ' + JSON.stringify(fields[name])).join(', ');
  } catch (problem) {
    kind = 'unreadable';
  }
  const row = make('tr', '', make('td', 'num', whole(tick)), make('td', '', player), make('td', '', kind), make('td', 'mono', rest));
  row.dataset.tick = String(tick);
  if (tick + 1 === focus) row.className = 'is-focus';
  return row;
}

function showInputs() {
  if (!film || film.input_count === 0) return;
  byId('inputs').hidden = false;
  const listed = film.input_lines.length;
  byId('inputs-note').textContent = count(film.input_count, 'input') + ' in ' + count(film.input_tick_count, 'tick') +
    (listed < film.input_count ? '; ' + whole(listed) + ' are listed, all by `ticktrue show FILE --inputs`' : '') +
    '. A click goes to the tick.';
  const body = byId('inputs-table').tBodies[0];
  const rows = document.createDocumentFragment();
  for (const [tick, line] of film.input_lines) rows.append(inputRow(tick, line));
  body.append(rows);
  body.addEventListener('click', (event) => {
    const row = event.target.closest('tr');
    if (row) { pause(); seek(Number(row.dataset.tick) + 1); }
  });
}

function markInputRows() {
  for (const row of byId('inputs-table').querySelectorAll('tr.is-now')) row.classList.remove('is-now');
  const rows = byId('inputs-table').tBodies[0].querySelectorAll('tr[data-tick="' + (shownTicks() - 1) + '"]');
  for (const row of rows) row.classList.add('is-now');
  if (rows.length > 0 && !player.isPlaying) {
    const box = byId('inputs-scroll');
    const top = rows[0].offsetTop - byId('inputs-table').tHead.offsetHeight;
    if (top < box.scrollTop || top > box.scrollTop + box.clientHeight - 60) box.scrollTop = top - 40;
  }
}
