// The list of problems of report.html, and the pictures of pairs, which are drawn when they are asked for.
// #method=2, #condition=1, #status=ok choose what is listed; #order=best turns it round; #pair=3 opens its third line
// and goes there, unless &scroll=no.
'use strict';
(() => {
  const data = diffsacPage.json('problems');
  const place = document.getElementById('problem-list');
  if (!data || !place) return;
  const pictures = diffsacPage.json('pictures') || [];
  const kPageLines = 50;

  // Small builders of elements: texts never become markup.
  const make = (tag, attributes = {}, ...children) => {
    const element = document.createElement(tag);
    for (const [key, value] of Object.entries(attributes)) {
      if (key.startsWith('on')) element.addEventListener(key.slice(2), value);
      else if (value === true) element.setAttribute(key, '');
      else if (value !== false && value !== null) element.setAttribute(key, value);
    }
    element.append(...children);
    return element;
  };
  const number = (value, digits = 3) => value === null ? '–' : value === Infinity ? '∞'
      : Math.abs(value) >= 1000 ? value.toFixed(0) : String(Number(value.toPrecision(digits)));

  // Lines of the list as objects; [problem, method, status, error, (R, t), (recall, structures),
  // inliers, hypotheses, ms] in the file.
  const unpack = (line) => {
    const [id, scene, condition, points, picture] = data.problems[line[0]];
    const recallAt = data.poses ? 6 : 4, at = recallAt + (data.structures ? 2 : 0);
    const known = (value) => value === 'inf' ? Infinity : value;
    return {problem: line[0], id, scene, condition, points, picture, method: line[1], status: data.statuses[line[2]],
            error: known(line[3]), rotation: data.poses ? known(line[4]) : null,
            translation: data.poses ? known(line[5]) : null, recall: data.structures ? line[recallAt] : null,
            structures: data.structures ? line[recallAt + 1] : null, inliers: line[at], hypotheses: line[at + 1],
            ms: known(line[at + 2])};
  };
  // "ok", or "ok, may be chance".
  const isModel = (line) => line.status.startsWith('ok');
  const lines = data.lines.map(unpack);
  const byProblem = new Map();
  for (const line of lines) {
    if (!byProblem.has(line.problem)) byProblem.set(line.problem, []);
    byProblem.get(line.problem).push(line);
  }
  const hasTruth = lines.some((line) => line.error !== null);
  const unit = data.unit;
  const errorText = (line) => line.error === null ? '–' : `${number(line.error)}${unit === '°' ? '°' : ' ' + unit}`;

  const columns = [
    {name: data.two_view ? 'pair' : 'problem', of: (line) => line.id},
    ...(data.scenes.length > 1 ? [{name: 'scene', of: (line) => data.scenes[line.scene]}] : []),
    ...(data.conditions.length > 1 ? [{name: data.condition_label, of: (line) => data.conditions[line.condition]}] : []),
    {name: 'method', of: (line) => data.methods[line.method]},
    {name: 'status', of: (line) => line.status},
    {name: `error [${unit}]`, of: (line) => line.error, numeric: true, key: 'error'},
    ...(data.poses ? [{name: 'R [°]', of: (line) => line.rotation, numeric: true},
                      {name: 't [°]', of: (line) => line.translation, numeric: true}] : []),
    ...(data.structures ? [{name: 'recall', of: (line) => line.recall, numeric: true},
                           {name: 'structures', of: (line) => line.structures, numeric: true}] : []),
    {name: 'inliers', of: (line) => line.inliers, numeric: true, key: 'inliers'},
    {name: data.two_view ? 'matches' : 'points', of: (line) => line.points, numeric: true},
    {name: 'hypotheses', of: (line) => line.hypotheses, numeric: true},
    {name: 'ms', of: (line) => line.ms, numeric: true},
  ];

  const state = {
    method: -1, condition: -1, scene: -1, status: 'all', text: '', page: 0, shown: [],
    // Without truth, few inliers are what looks worst.
    column: columns.findIndex((column) => column.key === (hasTruth ? 'error' : 'inliers')), direction: hasTruth ? -1 : 1,
  };

  // --- The list ---

  const heads = columns.map((column, i) => make('th',
      {scope: 'col', 'aria-sort': 'none', class: column.numeric ? 'number' : null},
      make('button', {type: 'button', onclick: () => sortBy(i)}, column.name)));
  const body = make('tbody');
  const table = make('table', {id: 'problems-table'}, make('thead', {}, make('tr', {}, ...heads)), body);
  const count = make('span', {id: 'problems-count', 'aria-live': 'polite'});
  const previous = make('button', {type: 'button', onclick: () => turn(-1)}, '← previous lines');
  const next = make('button', {type: 'button', onclick: () => turn(1)}, 'next lines →');

  const choice = (label, names, key, all) => {
    const select = make('select', {id: `choose-${key}`, onchange: () => {
      state[key] = key === 'status' ? select.value : Number(select.value);
      state.page = 0;
      refresh();
    }}, make('option', {value: key === 'status' ? 'all' : -1}, all));
    names.forEach((name, i) => select.append(make('option', {value: key === 'status' ? name : i}, name)));
    return make('label', {}, label, ' ', select);
  };
  const used = new Set(lines.map((line) => line.method));
  const search = make('input', {type: 'search', placeholder: 'part of a name', 'aria-label': 'search', oninput: () => {
    state.text = search.value.toLowerCase();
    state.page = 0;
    refresh();
  }});
  const order = (name, direction) => make('button', {type: 'button', onclick: () => {
    const column = columns.findIndex((c) => c.key === (hasTruth ? 'error' : 'inliers'));
    sortBy(column, hasTruth ? direction : -direction);
  }}, name);
  const controls = make('div', {class: 'controls'},
      choice('method', data.methods, 'method', 'all'),
      ...(data.conditions.length > 1 ? [choice(data.condition_label, data.conditions, 'condition', 'all')] : []),
      ...(data.scenes.length > 1 ? [choice('scene', data.scenes, 'scene', 'all')] : []),
      choice('status', data.statuses, 'status', 'all'), search, order('worst first', -1), order('best first', 1));
  for (const option of controls.querySelectorAll('#choose-method option'))
    if (option.value !== '-1' && !used.has(Number(option.value))) option.remove();

  const wanted = (line) => (state.method < 0 || line.method === state.method) &&
      (state.condition < 0 || line.condition === state.condition) && (state.scene < 0 || line.scene === state.scene) &&
      (state.status === 'all' || line.status === state.status) &&
      (!state.text || line.id.toLowerCase().includes(state.text));

  const sortBy = (column, direction) => {
    state.direction = direction || diffsacPage.nextDirection(heads[column], columns[column].numeric);
    state.column = column;
    state.page = 0;
    refresh();
  };
  const turn = (pages) => {
    state.page += pages;
    draw();
  };

  const refresh = () => {
    const of = columns[state.column].of;
    state.shown = lines.filter(wanted).map((line) => [of(line), line]);
    state.shown.sort((a, b) => diffsacPage.compare(a[0], b[0], state.direction));
    state.shown = state.shown.map((pair) => pair[1]);
    diffsacPage.mark(heads[state.column], state.direction);
    draw();
  };

  const row = (line, at) => {
    const opens = line.picture >= 0;
    const cells = columns.map((column, i) => {
      const value = column.of(line);
      const text = column.numeric ? number(value) : value;
      return make('td', {class: column.numeric ? 'number' : null}, i === 0 && opens ? make('a', {href: `#pair=${at + 1}`,
        onclick: (event) => { event.preventDefault(); open(at); }}, text) : text);
    });
    return make('tr', {class: (opens ? 'opens' : '') + (isModel(line) ? '' : ' failed') +
        (line === viewer.line ? ' current' : ''), onclick: (event) => {
      if (opens && event.target.tagName !== 'A') open(at);
    }}, ...cells);
  };

  const draw = () => {
    const last = Math.max(0, Math.ceil(state.shown.length / kPageLines) - 1);
    state.page = Math.min(Math.max(0, state.page), last);
    const first = state.page * kPageLines;
    body.replaceChildren(...state.shown.slice(first, first + kPageLines).map((line, i) => row(line, first + i)));
    const end = Math.min(first + kPageLines, state.shown.length);
    count.textContent = state.shown.length === 0 ? 'nothing fits this choice'
        : `${first + 1}–${end} of ${state.shown.length}`;
    previous.disabled = state.page === 0;
    next.disabled = state.page === last;
  };

  // --- The picture of a pair ---

  const kKinds = ['other', 'missed', 'right', 'wrong'];  // In the order in which they are drawn.
  const viewer = {line: null, at: -1, picture: null, kinds: new Set(kKinds), lines: 100, images: []};
  const title = make('h3', {id: 'pair-title'});
  const facts = make('p', {id: 'pair-facts'});
  const methods = make('div', {class: 'methods', role: 'group', 'aria-label': 'method'});
  const legend = make('div', {class: 'legend'});
  const canvas = make('canvas', {id: 'pair-canvas', role: 'img'});
  const howMany = make('select', {onchange: () => { viewer.lines = Number(howMany.value); paint(); }},
      make('option', {value: 100}, '100 of a colour'), make('option', {value: 1e9}, 'all'),
      make('option', {value: 0}, 'none'));
  const panel = make('section', {id: 'pair', hidden: true, 'aria-labelledby': 'pair-title'},
      make('div', {class: 'controls'},
          make('button', {type: 'button', onclick: () => step(-1)}, '← previous'),
          make('button', {type: 'button', onclick: () => step(1)}, 'next →'),
          make('button', {type: 'button', onclick: () => close()}, 'close'),
          make('span', {class: 'note'}, 'keys: ← → pairs, m next method, Esc closes')),
      title, methods, facts, canvas, legend);

  const texts = {right: 'right inliers', wrong: 'wrong inliers', missed: 'missed inliers', other: 'other matches'};

  const readPicture = (at) => {
    const [points, w1, h1, w2, h2, image1, image2, truth, methodNumbers] = pictures[at];
    const packed = diffsacPage.bytes(`points-${points}`);
    const view = new DataView(packed.buffer);
    const stepSize = view.getFloat32(0, true), n = (packed.length - 4) / 8;
    const places = new Float32Array(4 * n);
    for (let i = 0; i < 4 * n; ++i) {
      const value = view.getInt16(4 + 2 * i, true);
      places[i] = value === -32768 ? NaN : value * stepSize;
    }
    const masks = diffsacPage.bytes(`masks-${at}`), size = (n + 7) >> 3;
    const mask = (k) => masks.subarray(k * size, (k + 1) * size);
    const found = new Map(methodNumbers.map((method, i) => [method, mask(i + (truth ? 1 : 0))]));
    return {n, places, sizes: [[w1, h1], [w2, h2]], images: [image1, image2], truth: truth ? mask(0) : null, found};
  };
  const bit = (mask, i) => (mask[i >> 3] >> (i & 7)) & 1;

  const kindsOf = (picture, method) => {
    const found = picture.found.get(method), kinds = new Uint8Array(picture.n), counts = [0, 0, 0, 0];
    for (let i = 0; i < picture.n; ++i) {
      const isFound = found ? bit(found, i) : 0;
      const isTrue = picture.truth ? bit(picture.truth, i) : isFound;
      kinds[i] = isFound ? (isTrue ? 2 : 3) : isTrue ? 1 : 0;
      ++counts[kinds[i]];
    }
    return {kinds, counts, known: Boolean(found)};
  };

  const loadImage = (at) => new Promise((resolve) => {
    const element = at >= 0 ? document.getElementById(`image-${at}`) : null;
    if (!element) return resolve(null);
    const image = new Image();
    image.onload = () => resolve(image);
    image.onerror = () => resolve(null);
    image.src = 'data:image/jpeg;base64,' + element.textContent;
  });

  const fillLegend = (kinds) => {
    const truth = viewer.picture.truth;
    legend.replaceChildren();
    for (const kind of ['right', 'wrong', 'missed', 'other']) {
      if (!truth && (kind === 'wrong' || kind === 'missed')) continue;
      const box = make('input', {type: 'checkbox', checked: viewer.kinds.has(kind), onchange: () => {
        if (box.checked) viewer.kinds.add(kind); else viewer.kinds.delete(kind);
        paint();
      }});
      legend.append(make('label', {class: kind}, box, make('i', {}),
          ` ${kinds.counts[kKinds.indexOf(kind)]} ${truth ? texts[kind] : kind === 'right' ? 'inliers (truth unknown)' : texts[kind]}`));
    }
    legend.append(make('label', {}, 'lines: ', howMany));
  };

  const drawKind = (context, k, kinds, panels, colour) => {
    const {places, n} = viewer.picture, rows = [];
    for (let i = 0; i < n; ++i) if (kinds[i] === k && !Number.isNaN(places[4 * i] + places[4 * i + 1] + places[4 * i + 2] + places[4 * i + 3])) rows.push(i);
    const at = (i, side) => {
      const p = panels[side];
      return [p.x + places[4 * i + 2 * side] * p.scale, p.y + places[4 * i + 2 * side + 1] * p.scale];
    };
    const count = k === 0 ? 0 : Math.min(rows.length, viewer.lines);
    context.strokeStyle = context.fillStyle = colour;
    context.globalAlpha = count > 300 ? 0.3 : 0.6;
    context.lineWidth = 1;
    context.beginPath();
    for (let j = 0; j < count; ++j) {
      const i = rows[Math.floor(j * rows.length / count)];
      context.moveTo(...at(i, 0));
      context.lineTo(...at(i, 1));
    }
    context.stroke();
    context.globalAlpha = k === 0 ? 0.7 : 1;
    context.beginPath();
    for (const i of rows) for (const side of [0, 1]) {
      const [x, y] = at(i, side);
      context.moveTo(x + 2, y);
      context.arc(x, y, k === 0 ? 1.5 : 2.2, 0, 2 * Math.PI);
    }
    context.fill();
    context.globalAlpha = 1;
  };

  const paint = () => {
    const picture = viewer.picture;
    if (!picture) return;
    const gap = 8, width = Math.max(320, panel.clientWidth - 2), sharp = window.devicePixelRatio || 1;
    const most = Math.max(260, Math.min(900, 0.72 * window.innerHeight));
    // Beside each other or, where that makes them larger, one above the other.
    const within = (across, down) => picture.sizes.map(([w, h]) => Math.min(across / w, down / h));
    const beside = within((width - gap) / 2, most), above = within(width, (most - gap) / 2);
    const stacked = above[0] > 1.1 * beside[0], scales = stacked ? above : beside;
    const panels = picture.sizes.map(([w, h], i) => ({scale: scales[i], y: 0, w: w * scales[i], h: h * scales[i]}));
    panels[0].x = 0;
    panels[1].x = stacked ? 0 : panels[0].w + gap;
    if (stacked) panels[1].y = panels[0].h + gap;
    const height = Math.max(panels[0].h, panels[1].y + panels[1].h), total = Math.max(panels[0].w, panels[1].x + panels[1].w);
    canvas.width = Math.round(total * sharp);
    canvas.height = Math.round(height * sharp);
    canvas.style.width = `${total}px`;
    const style = getComputedStyle(document.documentElement);
    const context = canvas.getContext('2d');
    context.scale(sharp, sharp);
    panels.forEach((p, i) => {
      context.fillStyle = style.getPropertyValue('--raised');
      context.fillRect(p.x, p.y, p.w, p.h);
      if (!viewer.images[i]) return;
      context.globalAlpha = 0.7;  // Paler, so that the matches stand out.
      context.drawImage(viewer.images[i], p.x, p.y, p.w, p.h);
      context.globalAlpha = 1;
    });
    const {kinds, counts} = viewer.kindsNow;
    kKinds.forEach((kind, k) => {
      if (viewer.kinds.has(kind)) drawKind(context, k, kinds, panels, style.getPropertyValue(`--${kind}`));
    });
    canvas.setAttribute('aria-label', `matches of ${viewer.line.id}: ${counts[2]} right, ${counts[3]} wrong, ${counts[1]} missed`);
  };

  const showMethod = (line) => {
    viewer.line = line;
    viewer.kindsNow = kindsOf(viewer.picture, line.method);
    const others = byProblem.get(line.problem);
    methods.replaceChildren(...others.map((other) => make('button',
        {type: 'button', 'aria-pressed': String(other === line), onclick: () => showMethod(other)},
        data.methods[other.method], make('small', {}, ' ', isModel(other) ? errorText(other) : other.status))));
    const pose = data.poses && line.rotation !== null ? ` (R ${number(line.rotation)}°, t ${number(line.translation)}°)` : '';
    const found = data.structures && line.recall !== null ? `, recall ${number(line.recall)}, ${line.structures} structures found` : '';
    facts.textContent = `${data.methods[line.method]}: ` + (!isModel(line) ? `no model (${line.status}); ` : '') +
        `error ${errorText(line)}${pose}${found}; ${line.inliers} inliers of ${line.points} matches; ` +
        `${line.hypotheses} hypotheses, ${number(line.ms)} ms` +
        (viewer.kindsNow.known ? '' : '; which matches are its inliers was not kept');
    fillLegend(viewer.kindsNow);
    paint();
    draw();
  };

  const open = async (at, scroll = true) => {
    const line = state.shown[at];
    if (!line || line.picture < 0) return;
    const start = performance.now();
    viewer.at = at;
    viewer.picture = readPicture(line.picture);
    viewer.images = [];
    state.page = Math.floor(at / kPageLines);
    const where = [data.scenes.length > 1 ? data.scenes[line.scene] : '',
                   data.conditions.length > 1 ? `${data.condition_label} ${data.conditions[line.condition]}` : ''];
    title.textContent = [line.id, ...where.filter((part) => part)].join(' · ');
    panel.hidden = false;
    showMethod(line);
    const images = await Promise.all(viewer.picture.images.map(loadImage));
    if (viewer.at !== at) return;
    viewer.images = images;
    paint();
    panel.dataset.openedMs = (performance.now() - start).toFixed(1);
    if (scroll) panel.scrollIntoView({block: 'start'});
    try { history.replaceState(null, '', `#pair=${at + 1}`); } catch (error) { /* Not where the page's address has no history. */ }
  };
  const close = () => {
    panel.hidden = true;
    viewer.line = viewer.picture = null;
    viewer.at = -1;
    draw();
  };
  // The next line that has a picture.
  const step = (by) => {
    let at = viewer.at + by;
    while (state.shown[at] && state.shown[at].picture < 0) at += by;
    open(at, false);
  };

  document.addEventListener('keydown', (event) => {
    if (panel.hidden || event.ctrlKey || event.altKey || event.metaKey) return;
    if (['INPUT', 'SELECT', 'TEXTAREA'].includes(event.target.tagName)) return;
    if (event.key === 'ArrowLeft') step(-1);
    else if (event.key === 'ArrowRight') step(1);
    else if (event.key === 'Escape') close();
    else if (event.key === 'm') {
      const others = byProblem.get(viewer.line.problem);
      showMethod(others[(others.indexOf(viewer.line) + 1) % others.length]);
    } else return;
    event.preventDefault();
  });
  window.addEventListener('resize', () => { if (!panel.hidden) paint(); });

  place.append(controls, panel, make('div', {class: 'table'}, table),
      make('div', {class: 'controls'}, previous, next, count));

  // --- What the page's address asks for; otherwise the method whose errors rank the problems. ---

  const {wishes} = diffsacPage;
  state.method = wishes.has('method') ? Number(wishes.get('method')) - 1 : used.has(data.method) ? data.method : -1;
  if (wishes.has('condition')) state.condition = Number(wishes.get('condition')) - 1;
  if (wishes.has('status')) state.status = wishes.get('status');
  if (wishes.get('order') === 'best') state.direction = -state.direction;
  for (const key of ['method', 'condition', 'status']) {
    const select = document.getElementById(`choose-${key}`);
    if (select) select.value = String(state[key]);
  }
  refresh();
  if (wishes.has('pair')) open(Number(wishes.get('pair')) - 1, wishes.get('scroll') !== 'no');
  place.dataset.readyMs = performance.now().toFixed(1);
})();
