// The list of problems of report.html, and the pictures of pairs, which are drawn when they are asked for.
// A line opens what is known of it: the picture, where it has one, and the model.
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
  const number = (value, digits = 3) => value === null || value === undefined ? '–' : value === Infinity ? '∞'
      : Math.abs(value) >= 1e7 ? value.toExponential(digits - 1)
      : Math.abs(value) >= 1000 ? value.toFixed(0) : String(Number(value.toPrecision(digits)));

  // Lines of the list as objects; [problem, method, status, error, (R, t), (recall, structures),
  // inliers, hypotheses, ms] in the file.
  const details = data.details || {};
  const unpack = (line, position) => {
    const [id, scene, condition, points, picture] = data.problems[line[0]];
    const recallAt = data.poses ? 6 : 4, at = recallAt + (data.structures ? 2 : 0);
    const known = (value) => value === 'inf' ? Infinity : value;
    return {problem: line[0], id, scene, condition, points, picture, method: line[1], status: data.statuses[line[2]],
            error: known(line[3]), rotation: data.poses ? known(line[4]) : null,
            translation: data.poses ? known(line[5]) : null, recall: data.structures ? line[recallAt] : null,
            structures: data.structures ? line[recallAt + 1] : null, inliers: line[at], hypotheses: line[at + 1],
            ms: known(line[at + 2]), details: details[position] || null};
  };
  // "ok", or "ok, may be chance".
  const isModel = (line) => line.status.startsWith('ok');
  const lines = data.lines.map(unpack);
  const byProblem = new Map();
  for (const line of lines) {
    if (!byProblem.has(line.problem)) byProblem.set(line.problem, []);
    byProblem.get(line.problem).push(line);
  }
  const noiseOf = (line) => line.details ? line.details.noise : null;
  const hasNoise = lines.some((line) => noiseOf(line) !== null);
  const hasTruth = lines.some((line) => line.error !== null);
  const unit = data.unit;
  const errorText = (line) => line.error === null ? '–' : `${number(line.error)}${unit === '°' ? '°' : ' ' + unit}`;

  // `help` explains a column.
  const columns = [
    {name: data.two_view ? 'pair' : 'problem', of: (line) => line.id,
     help: data.two_view ? 'the two images; a click opens them with their matches' : 'the name of the input'},
    ...(data.scenes.length > 1 ? [{name: 'scene', of: (line) => data.scenes[line.scene], help: 'the folder that it is of'}] : []),
    ...(data.conditions.length > 1 ? [{name: data.condition_label, of: (line) => data.conditions[line.condition],
                                    help: 'how the data was made or filtered'}] : []),
    {name: 'method', of: (line) => data.methods[line.method], help: 'the row of the tables'},
    {name: 'status', of: (line) => line.status,
     help: 'ok, or why there is no model; "may be chance": no more inliers than points of no structure would give'},
    ...(hasTruth ? [{name: `error [${unit}]`, of: (line) => line.error, numeric: true, key: 'error',
                     help: data.structures ? 'per cent of the points whose label is wrong'
                         : data.poses ? 'the larger of R and t, ∞ or 180 without a model' : 'distance to the truth'}] : []),
    ...(data.poses && hasTruth ? [{name: 'R [°]', of: (line) => line.rotation, numeric: true,
                                   help: 'angle between the rotation and the true one'},
                                  {name: 't [°]', of: (line) => line.translation, numeric: true,
                                   help: 'angle between the direction of the translation and the true one'}] : []),
    ...(data.structures ? [{name: 'recall', of: (line) => line.recall, numeric: true, help: 'share of the true structures that were found'},
                           {name: 'structures', of: (line) => line.structures, numeric: true, help: 'how many were found'}] : []),
    {name: 'inliers', of: (line) => line.inliers, numeric: true, key: 'inliers',
     help: `${data.two_view ? 'matches' : 'points'} that the model explains within the inlier threshold`},
    {name: data.two_view ? 'matches' : 'points', of: (line) => line.points, numeric: true, help: 'how many there are'},
    ...(hasNoise ? [{name: `noise${data.two_view ? ' [px]' : ''}`, of: noiseOf, numeric: true,
                     help: "standard deviation of the inliers' residuals, in the unit of the data"}] : []),
    {name: 'hypotheses', of: (line) => line.hypotheses, numeric: true, help: 'models solved or scored'},
    {name: 'ms', of: (line) => line.ms, numeric: true, help: 'milliseconds of the estimate'},
  ];

  const state = {
    method: -1, condition: -1, scene: -1, status: 'all', text: '', page: 0, shown: [],
    // Without truth, few inliers are what looks worst.
    column: columns.findIndex((column) => column.key === (hasTruth ? 'error' : 'inliers')), direction: hasTruth ? -1 : 1,
  };

  // --- The list ---

  const heads = columns.map((column, i) => make('th',
      {scope: 'col', 'aria-sort': 'none', class: column.numeric ? 'number' : null},
      make('button', {type: 'button', title: column.help, onclick: () => sortBy(i)}, column.name)));
  const words = make('details', {}, make('summary', {}, 'What the columns mean'), make('dl', {class: 'words'},
      ...columns.flatMap((column) => [make('dt', {}, column.name), make('dd', {}, column.help)])));
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
      choice('status', data.statuses, 'status', 'all'), search,
      order(hasTruth ? 'worst first' : 'fewest inliers first', -1), order(hasTruth ? 'best first' : 'most inliers first', 1));
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

  const opensLine = (line) => line.picture >= 0 || line.details !== null;

  // Small copies of the photographs of a line, each decoded once.
  const thumbnails = new Map();
  const thumbnail = (image) => {
    if (!thumbnails.has(image)) {
      const bytes = image >= 0 ? diffsacPage.bytes(`image-${image}`) : null;
      thumbnails.set(image, bytes ? URL.createObjectURL(new Blob([bytes], {type: 'image/jpeg'})) : '');
    }
    return thumbnails.get(image);
  };
  const thumbnailsOf = (line) => line.picture < 0 ? [] : pictures[line.picture].slice(5, 7).map(thumbnail)
      .filter((address) => address).map((address) => make('img', {src: address, alt: '', loading: 'lazy'}));

  const row = (line, at) => {
    const opens = opensLine(line);
    const cells = columns.map((column, i) => {
      const value = column.of(line);
      const text = column.numeric ? number(value) : value;
      return make('td', {class: column.numeric ? 'number' : null}, i === 0 && opens ? make('a', {href: `#pair=${at + 1}`,
        onclick: (event) => { event.preventDefault(); open(at); }}, ...thumbnailsOf(line), text) : text);
    });
    return make('tr', {class: (opens ? 'opens' : '') + (isModel(line) ? '' : ' failed') +
        (line === viewer.line ? ' current' : ''), onclick: (event) => {
      if (opens && event.target.closest('a') === null) open(at);
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
  const model = make('pre', {id: 'pair-model', hidden: true});
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
          make('span', {class: 'note'}, 'keys: ← → through the list, m next method, Esc closes')),
      title, methods, facts, canvas, legend, model);

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

  // --- What is known of a model ---

  const fixed = (value) => (value < 0 ? '' : ' ') + (Math.abs(value) >= 1e5 || (value !== 0 && Math.abs(value) < 1e-4)
      ? value.toExponential(5) : value.toPrecision(7));
  const matrix = (name, values, width) => {
    const rows = [];
    for (let i = 0; i < values.length; i += width)
      rows.push((i === 0 ? `${name} = ` : ' '.repeat(name.length + 3)) +
                values.slice(i, i + width).map((value) => fixed(value).padStart(14)).join(''));
    return rows.join('\n');
  };
  // R row by row: its angle in degrees and its axis.
  const turnOf = (r) => {
    const axis = [r[7] - r[5], r[2] - r[6], r[3] - r[1]], length = Math.hypot(...axis);
    const angle = Math.atan2(length, r[0] + r[4] + r[8] - 1) * 180 / Math.PI;
    return `turned by ${number(angle, 4)}°` +
        (length > 1e-9 ? ` about (${axis.map((value) => number(value / length, 4)).join(', ')})` : '');
  };
  const rotationOf = (pose) => [0, 1, 2, 4, 5, 6, 8, 9, 10].map((i) => pose[i]);
  const poseText = (pose, undetermined) => {
    const rotation = rotationOf(pose), t = [pose[3], pose[7], pose[11]];
    const turn = `${matrix('R', rotation, 3)}\n    ${turnOf(rotation)}`;
    if (undetermined) return turn;
    return `${turn}\n${matrix('t', t, 3)}` +
        (data.two_view ? '   (its length is unknown; x2 = R x1 + t)' : '   (x_camera = R X + t)');
  };
  const modelText = (line) => {
    if (!line.details) return '';
    const parts = [], {noise, model: values, pose, undetermined} = line.details;
    const names = {homography: 'H', fundamental: 'F', essential: 'E', shared_focal: 'E', one_focal: 'E', two_focals: 'E'};
    if (undetermined) parts.push(undetermined);
    else if (values && names[data.task]) parts.push(matrix(names[data.task], values.slice(0, 9), 3));
    else if (values && (data.task === 'line' || data.task === 'plane'))
      // All digits: far from the origin few of a normal miss the points.
      parts.push(`n = (${values.slice(0, -1).join(', ')})\n` +
                 `d = ${values[values.length - 1]}   (n · x + d = 0, |n| = 1, in the unit of the points)`);
    else if (values && !pose) parts.push(`model = ${values.map((value) => number(value, 7)).join(' ')}`);
    if (pose) parts.push(poseText(pose, undetermined));
    if (noise !== null) parts.push(`noise σ = ${number(noise)}${data.two_view ? ' px' : ''}`);
    return parts.join('\n');
  };

  const showMethod = (line) => {
    viewer.line = line;
    viewer.kindsNow = viewer.picture ? kindsOf(viewer.picture, line.method) : {known: true};
    const others = byProblem.get(line.problem);
    methods.replaceChildren(...others.map((other) => make('button',
        {type: 'button', 'aria-pressed': String(other === line), onclick: () => showMethod(other)},
        data.methods[other.method], make('small', {}, ' ', !isModel(other) ? other.status : other.error === null ? `${other.inliers} inliers` : errorText(other)))));
    const pose = data.poses && line.rotation !== null ? ` (R ${number(line.rotation)}°, t ${number(line.translation)}°)` : '';
    const found = data.structures && line.recall !== null ? `, recall ${number(line.recall)}, ${line.structures} structures found` : '';
    facts.textContent = `${data.methods[line.method]}: ` + (!isModel(line) ? `no model (${line.status}); ` : '') +
        (line.error === null ? '' : `error ${errorText(line)}${pose}${found}; `) +
        `${line.inliers} inliers of ${line.points} ${data.two_view ? 'matches' : 'points'}; ` +
        (noiseOf(line) === null ? '' : `noise ${number(noiseOf(line))}${data.two_view ? ' px' : ''}; `) +
        `${line.hypotheses} hypotheses, ${number(line.ms)} ms` +
        (line.details && line.details.pose ? `; ${turnOf(rotationOf(line.details.pose))}` : '') +
        (viewer.kindsNow.known ? '' : '; which matches are its inliers was not kept');
    model.textContent = modelText(line);
    model.hidden = model.textContent === '';
    canvas.hidden = legend.hidden = !viewer.picture;
    if (viewer.picture) fillLegend(viewer.kindsNow);
    paint();
    draw();
  };

  const open = async (at, scroll = true) => {
    const line = state.shown[at];
    if (!line || !opensLine(line)) return;
    const start = performance.now();
    viewer.at = at;
    viewer.picture = line.picture >= 0 ? readPicture(line.picture) : null;
    viewer.images = [];
    state.page = Math.floor(at / kPageLines);
    const where = [data.scenes.length > 1 ? data.scenes[line.scene] : '',
                   data.conditions.length > 1 ? `${data.condition_label} ${data.conditions[line.condition]}` : ''];
    title.textContent = [line.id, ...where.filter((part) => part)].join(' · ');
    panel.hidden = false;
    showMethod(line);
    const images = viewer.picture ? await Promise.all(viewer.picture.images.map(loadImage)) : [];
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
  // The next line that opens.
  const step = (by) => {
    let at = viewer.at + by;
    while (state.shown[at] && !opensLine(state.shown[at])) at += by;
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
      make('div', {class: 'controls'}, previous, next, count), words);

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
