'use strict';
(function () {
  const root = document.documentElement;
  const $ = (id) => document.getElementById(id);

  // A page that fails says so to its reader, and to whoever tests it.
  function fail(message) {
    root.dataset.error = message;
    $('problem').textContent = message;
    $('problem').hidden = false;
  }
  addEventListener('error', (event) => fail(event.message));
  addEventListener('unhandledrejection', (event) => fail(String(event.reason)));

  const hash = () => new URLSearchParams(location.hash.slice(1));
  const dark = () => (root.dataset.theme ? root.dataset.theme === 'dark'
    : matchMedia('(prefers-color-scheme: dark)').matches);
  if (hash().get('theme')) root.dataset.theme = hash().get('theme');

  const given = JSON.parse($('data').textContent);

  function bytes(text) {
    const binary = atob(text);
    const result = new Uint8Array(binary.length);
    for (let i = 0; i < binary.length; i++) result[i] = binary.charCodeAt(i);
    return result;
  }

  function rgb(hex) { return [1, 3, 5].map((i) => parseInt(hex.substr(i, 2), 16)); }

  // 256 colours of a map given in few steps.
  function ramp(steps) {
    const known = steps.map(rgb), result = new Uint8Array(768);
    for (let i = 0; i < 256; i++) {
      const at = (i / 255) * (known.length - 1), k = Math.min(Math.floor(at), known.length - 2);
      for (let c = 0; c < 3; c++) result[3 * i + c] = known[k][c] + (at - k) * (known[k + 1][c] - known[k][c]);
    }
    return result;
  }

  // ---------------------------------------------------------------- series

  class Series {
    constructor(data) {
      Object.assign(this, data);
      this.group = bytes(data.group);
      this.kind = data.kind ? bytes(data.kind) : new Uint8Array(this.count);
      this.thickest = Math.max(...this.radii);
      this.fibre = new Int32Array(this.count);
      this.next = new Int32Array(this.count).fill(-1);
      this.before = new Int32Array(this.count).fill(-1);
      let row = 0;
      this.runs.forEach((length, fibre) => {
        for (let k = 0; k < length; k++) {
          this.fibre[row + k] = fibre;
          if (k + 1 < length) this.next[row + k] = row + k + 1;
          else if (this.closed[fibre] && length > 2) this.next[row + k] = row;
        }
        row += length;
      });
      for (let i = 0; i < this.count; i++) if (this.next[i] >= 0) this.before[this.next[i]] = i;
    }

    // Half of the box of a frame, by which bonds through the boundary are told.
    half(frame) {
      const ways = this.frames[frame].box.slice(1);
      return ways.map((way, d) => (this.periodic[d] ? 0.5 * way[d] : Infinity));
    }

    // Ends of the edges of a frame's box, about the middle of all frames.
    edges(frame) {
      const [corner, ...ways] = this.frames[frame].box, ends = [];
      for (let d = 0; d < 3; d++) {
        for (let k = 0; k < 4; k++) {
          const others = [0, 1, 2].filter((e) => e !== d).filter((_, i) => k >> i & 1);
          for (const along of [others, [...others, d]]) {
            for (let c = 0; c < 3; c++) {
              ends.push(along.reduce((sum, e) => sum + ways[e][c], corner[c]) - this.low[c] - this.span[c] / 2);
            }
          }
        }
      }
      return new Float32Array(ends);
    }

    // Positions of a frame, about the middle of all frames.
    position(frame) {
      const data = this.frames[frame];
      if (!data.read) data.read = new Uint16Array(bytes(data.position).buffer);
      const x = new Float32Array(3 * this.count), scale = this.span.map((side) => side / 65535);
      for (let i = 0; i < x.length; i++) {
        const d = i % 3;
        x[i] = data.read[i] * scale[d] - 0.5 * this.span[d];
      }
      return x;
    }

    values(field, frame) {
      if (!field.read) field.read = field.values.map(bytes);
      return field.read[frame];
    }

    torn(frame) {
      const data = this.frames[frame];
      if (!data.gap) {
        data.gap = new Uint8Array(this.count);
        data.torn.forEach((row) => { data.gap[row] = 1; });
      }
      return data.gap;
    }
  }

  const all = given.series.map((data) => new Series(data));
  const state = { series: 0, frame: 0, colour: '', playing: false };

  // ---------------------------------------------------------------- colours

  function choices(series) {
    const list = [['fibre', 'fibre'], ['height', 'height'], ['broken', 'broken fibres']];
    if (series.kinds.length > 1) list.unshift(['kind', 'kind']);
    if (series.groups.length > 1) list.push(['group', 'group']);
    return list.concat(series.fields.map((f) => [f.name, f.title]));
  }

  function unitText(value) {
    const size = Math.abs(value);
    if (size >= 1e4 || (size > 0 && size < 1e-3)) return value.toExponential(1).replace('e', ' e').replace('-', '−');
    return Number(value.toPrecision(3)).toString().replace('-', '−');
  }

  function bar(map, title, low, high) {
    const stops = [];
    for (let i = 0; i <= 16; i++) {
      const k = 3 * Math.round((i / 16) * 255);
      stops.push(`rgb(${map[k]},${map[k + 1]},${map[k + 2]})`);
    }
    return `<div>${title}</div><div class="bar" style="background:linear-gradient(90deg,${stops})"></div>
      <div class="ticks"><span>${unitText(low)}</span><span>${unitText((low + high) / 2)}</span><span>${unitText(high)}</span></div>`;
  }

  // A name of a file's as it stands in HTML.
  function text(name) {
    const element = document.createElement('i');
    element.textContent = name;
    return element.innerHTML;
  }

  function chips(list) {
    return `<div class="chips">${list.map(([name, colour]) =>
      `<span><i class="chip" style="background:${colour}"></i>${name}</span>`).join('')}</div>`;
  }

  // Colours of the segments, three bytes each, and what explains them.
  function colours(series, frame, name, x) {
    const maps = given.maps[dark() ? 'dark' : 'light'], out = new Uint8Array(3 * series.count);
    const paint = (i, map, k) => { for (let c = 0; c < 3; c++) out[3 * i + c] = map[3 * k + c]; };
    const field = series.fields.find((f) => f.name === name);
    if (field) {
      const map = ramp(field.low < 0 && field.high > 0 ? maps.diverging : maps.sequential);
      const values = series.values(field, frame);
      for (let i = 0; i < series.count; i++) paint(i, map, values[i]);
      return [out, bar(map, field.title, field.low, field.high)];
    }
    if (name === 'height') {
      const map = ramp(maps.sequential), [unit, size] = series.lengthUnit;
      const low = series.low[2], span = series.span[2] || 1;
      for (let i = 0; i < series.count; i++) {
        paint(i, map, Math.max(0, Math.min(255, Math.round(255 * (x[3 * i + 2] / span + 0.5)))));
      }
      return [out, bar(map, `height z, ${unit}`, low / size, (low + span) / size)];
    }
    if (name === 'group') {
      const palette = series.groups.map((mask, k) => (mask ? given.maps.groups[1 + (k - 1 + 7) % 7] : given.maps.groups[0]));
      const parts = palette.map(rgb);
      for (let i = 0; i < series.count; i++) out.set(parts[series.group[i]], 3 * i);
      const title = (mask) => (!mask ? 'no group' : mask === 2 ** 28 ? 'left grip' : mask === 2 ** 29 ? 'right grip' : `group mask ${mask}`);
      return [out, chips(series.groups.map((mask, k) => [title(mask), palette[k]]))];
    }
    if (name === 'broken') {
      const hurt = new Set(), whole = rgb(given.maps.whole), torn = rgb(given.maps.hurt);
      series.frames[frame].torn.forEach((row) => hurt.add(series.fibre[row]));
      for (let i = 0; i < series.count; i++) out.set(hurt.has(series.fibre[i]) ? torn : whole, 3 * i);
      return [out, chips([['whole fibres', given.maps.whole], ['broken fibres', given.maps.hurt]])];
    }
    // Neighbours in the list, often neighbours in space, differ in lightness.
    const shade = (i, colour, by) => {
      const factor = 1 - 0.5 * by + by * ((series.fibre[i] * 0.618034) % 1);
      for (let c = 0; c < 3; c++) out[3 * i + c] = Math.min(255, colour[c] * factor);
    };
    if (name === 'kind') {
      const palette = series.kinds.map((_, k) => maps.kinds[k % maps.kinds.length]);
      const parts = palette.map(rgb);
      for (let i = 0; i < series.count; i++) shade(i, parts[series.kind[i]], 0.16);
      return [out, chips(series.kinds.map((kind, k) => [text(kind), palette[k]]))];
    }
    const map = ramp(maps.fibres), n = series.runs.length;
    for (let i = 0; i < series.count; i++) {
      const k = Math.round(((series.fibre[i] + 0.5) / n) * 255);
      shade(i, map.subarray(3 * k, 3 * k + 3), 0.28);
    }
    return [out, `<div class="muted">${n} fibres, a colour each</div>`];
  }

  // ---------------------------------------------------------------- tubes

  const SHADING = `
    uniform vec3 haze; uniform float nearest; uniform float farthest;
    varying vec3 vNormal; varying vec3 vPlace; varying vec3 vColour;
    void main() {
      vec3 n = normalize(vNormal), eye = normalize(-vPlace);
      vec3 lamp = normalize(vec3(-0.45, 0.62, 0.75));
      float facing = max(dot(n, eye), 0.0);
      float diffuse = max(dot(n, lamp), 0.0);
      float sky = 0.5 + 0.5 * n.y;
      float gloss = pow(max(dot(n, normalize(lamp + eye)), 0.0), 42.0);
      vec3 base = vColour * vColour;
      vec3 lit = base * (0.30 + 0.16 * sky + 0.72 * diffuse) + 0.10 * gloss;
      // Darker rims tell tubes that cross apart.
      lit *= mix(0.38, 1.0, smoothstep(0.0, 0.55, facing));
      float depth = clamp((-vPlace.z - nearest) / (farthest - nearest), 0.0, 1.0);
      vec3 colour = mix(sqrt(clamp(lit, 0.0, 1.0)), haze, 0.42 * depth * depth);
      gl_FragColor = vec4(colour, 1.0);
    }`;
  const TUBE = `
    attribute vec3 a, b, ta, tb, ca, cb; attribute float radius;
    varying vec3 vNormal; varying vec3 vPlace; varying vec3 vColour;
    void main() {
      float end = position.y;  // 0 at a, 1 at b
      vec3 axis = normalize(b - a);
      vec3 tangent = normalize(mix(ta, tb, end));
      vec3 other = abs(axis.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0);
      vec3 u = normalize(cross(other, tangent)), v = cross(u, tangent);
      vec3 normal = position.x * u + position.z * v;
      vec4 place = modelViewMatrix * vec4(mix(a, b, end) + radius * normal, 1.0);
      vNormal = normalMatrix * normal; vPlace = place.xyz; vColour = mix(ca, cb, end);
      gl_Position = projectionMatrix * place;
    }`;
  const CAP = `
    attribute vec3 a, ca; attribute float radius;
    varying vec3 vNormal; varying vec3 vPlace; varying vec3 vColour;
    void main() {
      vec4 place = modelViewMatrix * vec4(a + radius * position, 1.0);
      vNormal = normalMatrix * position; vPlace = place.xyz; vColour = ca;
      gl_Position = projectionMatrix * place;
    }`;

  class Tubes {
    constructor(series, scene) {
      this.series = series;
      // Among many thin tubes a thick one still has to look round.
      const least = series.thickest > 2 * Math.min(...series.radii) ? 12 : 6;
      const sides = Math.max(least, series.count > 60000 ? 6 : series.count > 15000 ? 8 : 14);
      this.uniforms = { haze: { value: new THREE.Color() }, nearest: { value: 0 },
        farthest: { value: 1 } };
      const material = (vertexShader) => new THREE.ShaderMaterial(
        { vertexShader, fragmentShader: SHADING, uniforms: this.uniforms });
      const cylinder = new THREE.CylinderBufferGeometry(1, 1, 1, sides, 1, true);
      cylinder.translate(0, 0.5, 0);
      this.tube = this.mesh(cylinder, material(TUBE), series.count,
        { a: 3, b: 3, ta: 3, tb: 3, radius: 1 }, { ca: 3, cb: 3 });
      this.cap = this.mesh(new THREE.SphereBufferGeometry(1, sides, Math.max(4, sides / 2)), material(CAP),
        2 * series.count, { a: 3, radius: 1 }, { ca: 3 });
      scene.add(this.tube, this.cap);
    }

    mesh(shape, material, count, reals, colours) {
      const geometry = new THREE.InstancedBufferGeometry();
      geometry.index = shape.index;
      geometry.attributes.position = shape.attributes.position;
      const add = (name, size, array, normalised) => {
        const attribute = new THREE.InstancedBufferAttribute(array, size, normalised);
        attribute.setUsage ? attribute.setUsage(THREE.DynamicDrawUsage) : attribute.setDynamic(true);
        geometry.setAttribute(name, attribute);
      };
      Object.keys(reals).forEach((name) => add(name, reals[name], new Float32Array(reals[name] * count), false));
      Object.keys(colours).forEach((name) => add(name, colours[name], new Uint8Array(colours[name] * count), true));
      const mesh = new THREE.Mesh(geometry, material);
      mesh.frustumCulled = false;
      return mesh;
    }

    // Unit vectors along the fibres: at a segment between two bonds the mean of both.
    tangents(x, joined) {
      const s = this.series, t = new Float32Array(3 * s.count);
      for (let i = 0; i < s.count; i++) {
        let from = s.before[i], to = s.next[i];
        if (from < 0 || !joined[from]) from = i;
        if (to < 0 || !joined[i]) to = i;
        const d = [0, 1, 2].map((c) => x[3 * to + c] - x[3 * from + c]);
        const length = Math.hypot(d[0], d[1], d[2]) || 1;
        for (let c = 0; c < 3; c++) t[3 * i + c] = d[c] / length;
      }
      return t;
    }

    joined(frame, x, gap) {
      const s = this.series, half = s.half(frame), joined = new Uint8Array(s.count);
      for (let i = 0; i < s.count; i++) {
        const j = s.next[i];
        joined[i] = j >= 0 && !gap[i] && [0, 1, 2].every((c) => Math.abs(x[3 * j + c] - x[3 * i + c]) <= half[c]) ? 1 : 0;
      }
      return joined;
    }

    update(frame, colourName) {
      const s = this.series, x = s.position(frame), gap = s.torn(frame), joined = this.joined(frame, x, gap);
      const t = this.tangents(x, joined), [colour, key] = colours(s, frame, colourName, x);
      const at = this.tube.geometry.attributes, cap = this.cap.geometry.attributes, marks = colourName === 'broken';
      const tornBefore = (i) => s.before[i] >= 0 && gap[s.before[i]];
      let n = 0, m = 0;
      const end = (place, i, torn) => {
        cap.a.array.set(place, 3 * m);
        cap.radius.array[m] = s.radii[s.kind[i]] * (torn && marks ? 1.35 : 1);
        if (torn && marks) cap.ca.array.set([232, 66, 28], 3 * m);
        else cap.ca.array.set(colour.subarray(3 * i, 3 * i + 3), 3 * m);
        m++;
      };
      for (let i = 0; i < s.count; i++) {
        const p = x.subarray(3 * i, 3 * i + 3);
        const first = s.before[i] < 0 || !joined[s.before[i]];
        if (!joined[i]) {
          if (first) end(p, i, gap[i] || tornBefore(i));
          continue;
        }
        const j = s.next[i], q = x.subarray(3 * j, 3 * j + 3);
        const a = Array.from(p), b = Array.from(q);
        // A torn end is shorter, so that the gap is seen from the first moment on.
        if (tornBefore(i)) for (let c = 0; c < 3; c++) a[c] += 0.45 * (q[c] - p[c]);
        if (gap[j]) for (let c = 0; c < 3; c++) b[c] -= 0.45 * (q[c] - p[c]);
        at.radius.array[n] = s.radii[s.kind[i]];
        at.a.array.set(a, 3 * n);
        at.b.array.set(b, 3 * n);
        at.ta.array.set(t.subarray(3 * i, 3 * i + 3), 3 * n);
        at.tb.array.set(t.subarray(3 * j, 3 * j + 3), 3 * n);
        at.ca.array.set(colour.subarray(3 * i, 3 * i + 3), 3 * n);
        at.cb.array.set(colour.subarray(3 * j, 3 * j + 3), 3 * n);
        n++;
        if (first) end(a, i, tornBefore(i));
        if (s.next[j] < 0 || !joined[j]) end(b, j, gap[j]);
      }
      for (const [mesh, count] of [[this.tube, n], [this.cap, m]]) {
        mesh.geometry.maxInstancedCount = count;
        mesh.visible = count > 0;
        Object.values(mesh.geometry.attributes).forEach((attribute) => {
          if (attribute.isInstancedBufferAttribute) attribute.needsUpdate = true;
        });
      }
      root.dataset.tubes = n;
      return key;
    }

    dispose(scene) {
      for (const mesh of [this.tube, this.cap]) {
        scene.remove(mesh);
        mesh.geometry.dispose();
        mesh.material.dispose();
      }
    }
  }

  // ---------------------------------------------------------------- camera

  // Turns about a point, z upwards.
  class Orbit {
    constructor(camera, element, changed) {
      this.camera = camera;
      this.element = element;
      this.changed = changed;
      this.pointers = new Map();
      element.addEventListener('pointerdown', (e) => this.down(e));
      element.addEventListener('pointermove', (e) => this.move(e));
      for (const name of ['pointerup', 'pointercancel']) element.addEventListener(name, (e) => this.pointers.delete(e.pointerId));
      element.addEventListener('wheel', (e) => {
        e.preventDefault();
        this.zoom(Math.exp(Math.max(-0.4, Math.min(0.4, 0.0012 * e.deltaY * (e.deltaMode ? 30 : 1)))));
      }, { passive: false });
      element.addEventListener('contextmenu', (e) => e.preventDefault());
    }

    fit(middle, radius) {
      this.target = new THREE.Vector3(...middle);
      this.size = radius;
      this.azimuth = -1.15;
      this.elevation = 0.72;
      const narrow = Math.min(1, this.camera.aspect);
      this.distance = radius / Math.sin(Math.PI / 180 * this.camera.fov / 2) / narrow;
      this.place();
    }

    place() {
      const e = this.elevation, a = this.azimuth;
      const away = new THREE.Vector3(Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e));
      this.camera.up.set(0, 0, 1);
      this.camera.position.copy(this.target).addScaledVector(away, this.distance);
      this.camera.lookAt(this.target);
      this.camera.near = Math.max(this.distance - 4 * this.size, 0.004 * this.distance);
      this.camera.far = this.distance + 8 * this.size;
      this.camera.updateProjectionMatrix();
      this.changed();
    }

    zoom(factor) {
      this.distance = Math.max(0.02 * this.size, Math.min(20 * this.size, this.distance * factor));
      this.place();
    }

    down(e) {
      if (e.target.closest('button')) return;
      this.pointers.set(e.pointerId, [e.clientX, e.clientY]);
      this.element.setPointerCapture(e.pointerId);
    }

    move(e) {
      const old = this.pointers.get(e.pointerId);
      if (!old) return;
      const dx = e.clientX - old[0], dy = e.clientY - old[1];
      if (this.pointers.size === 2) {
        const other = [...this.pointers].find(([id]) => id !== e.pointerId)[1];
        const was = Math.hypot(old[0] - other[0], old[1] - other[1]);
        this.pan(dx / 2, dy / 2);
        this.zoom(was / Math.max(1, Math.hypot(e.clientX - other[0], e.clientY - other[1])));
      } else if (e.shiftKey || e.buttons & 6) {
        this.pan(dx, dy);
      } else {
        this.azimuth -= 0.006 * dx;
        this.elevation = Math.max(-1.55, Math.min(1.55, this.elevation + 0.006 * dy));
      }
      this.pointers.set(e.pointerId, [e.clientX, e.clientY]);
      this.place();
    }

    pan(dx, dy) {
      const scale = 2 * this.distance * Math.tan(Math.PI / 180 * this.camera.fov / 2) / this.element.clientHeight;
      const right = new THREE.Vector3().setFromMatrixColumn(this.camera.matrix, 0);
      const up = new THREE.Vector3().setFromMatrixColumn(this.camera.matrix, 1);
      this.target.addScaledVector(right, -dx * scale).addScaledVector(up, dy * scale);
    }
  }

  // ---------------------------------------------------------------- curve

  function niceStep(span, count) {
    const raw = span / count, decade = 10 ** Math.floor(Math.log10(raw));
    return [1, 2, 5, 10].map((k) => k * decade).find((step) => step >= raw);
  }

  function ticks(low, high, count) {
    const step = niceStep(high - low || 1, count), result = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) result.push(Number((k * step).toPrecision(12)));
    return result;
  }

  class Curve {
    constructor(element, seek) {
      this.element = element;
      const at = (e) => {
        if (!this.data || (e.type === 'pointermove' && !e.buttons)) return;
        const box = element.getBoundingClientRect();
        seek(this.frameAt((e.clientX - box.left - this.left) / this.width));
      };
      element.addEventListener('pointerdown', at);
      element.addEventListener('pointermove', at);
    }

    show(series) {
      this.series = series;
      this.data = series.curve;
      this.draw();
    }

    // Index in the curve of a frame's time.
    row(frame) {
      const t = this.data.time, seconds = this.series.frames[frame].seconds * (1 + 1e-12);
      let low = 0, high = t.length - 1;
      while (low < high) {
        const middle = (low + high + 1) >> 1;
        if (t[middle] <= seconds) low = middle; else high = middle - 1;
      }
      return low;
    }

    frameAt(share) {
      const wanted = this.low + share * (this.high - this.low);
      const off = this.series.frames.map((_, k) => Math.abs(this.data.x[this.row(k)] - wanted));
      return off.indexOf(Math.min(...off));
    }

    draw() {
      $('curve-title').textContent = '';
      this.element.innerHTML = '';
      if (!this.data) {
        this.element.innerHTML = '<p class="muted">No table of stress or energy belongs to these snapshots.</p>';
        return;
      }
      const { x, y, second, titles } = this.data;
      $('curve-title').textContent = titles[0][0].toUpperCase() + titles[0].slice(1);
      const w = Math.max(260, this.element.clientWidth), h = Math.max(240, Math.min(420, this.element.clientHeight || 300));
      Object.assign(this, { left: 46, top: 10, width: w - 46 - (second ? 40 : 12), height: h - 10 - 40 });
      this.low = Math.min(...x); this.high = Math.max(...x) || 1;
      const least = Math.min(0, ...y), most = Math.max(...y), margin = 0.06 * (most - least || 1);
      this.bottom = least < 0 ? least - margin : 0; this.peak = most + margin;
      this.px = (v) => this.left + ((v - this.low) / (this.high - this.low || 1)) * this.width;
      this.py = (v) => this.top + (1 - (v - this.bottom) / (this.peak - this.bottom)) * this.height;
      const parts = [];
      const label = (px, py, words, anchor, more = '') =>
        parts.push(`<text x="${px}" y="${py}" text-anchor="${anchor}" fill="var(--muted)" font-size="11.5" ${more}>${words}</text>`);
      for (const v of ticks(this.bottom, this.peak, 5)) {
        parts.push(`<line x1="${this.left}" x2="${this.left + this.width}" y1="${this.py(v)}" y2="${this.py(v)}" stroke="var(--line)"/>`);
        label(this.left - 7, this.py(v) + 4, unitText(v), 'end');
      }
      for (const v of ticks(this.low, this.high, 5)) label(this.px(v), this.top + this.height + 17, unitText(v), 'middle');
      label(this.left + this.width / 2, h - 5, titles[1], 'middle');
      label(0, 0, titles[2], 'middle', `transform="translate(11 ${this.top + this.height / 2}) rotate(-90)"`);
      if (second) this.steps(parts, label, w, second, titles[3]);
      const line = x.map((v, k) => `${this.px(v).toFixed(1)},${this.py(y[k]).toFixed(1)}`).join('L');
      parts.push(`<path d="M${line}" fill="none" stroke="var(--accent)" stroke-width="2" stroke-linejoin="round"/>`,
        `<line id="mark-line" y1="${this.top}" y2="${this.top + this.height}" stroke="var(--ink)" stroke-dasharray="2 3" opacity=".55"/>`,
        '<circle id="mark" r="6" fill="var(--card)" stroke="var(--ink)" stroke-width="2.5"/>');
      this.element.innerHTML = `<svg width="${w}" height="${h}" viewBox="0 0 ${w} ${h}">${parts.join('')}</svg>`;
      this.mark(state.frame);
    }

    // Broken bonds, behind the stress, on a scale of their own at the right.
    steps(parts, label, w, second, title) {
      const most = Math.max(1, ...second) * 1.15, zero = this.py(0), room = zero - this.top;
      const py = (v) => zero - (v / most) * room;
      let path = `M${this.px(this.data.x[0])},${zero}`;
      second.forEach((v, k) => { path += `H${this.px(this.data.x[k]).toFixed(1)}V${py(v).toFixed(1)}`; });
      parts.push(`<path d="${path}V${zero}Z" fill="var(--muted)" opacity=".16"/>`);
      for (const v of ticks(0, most / 1.15, 4)) if (Number.isInteger(v)) label(this.left + this.width + 6, py(v) + 4, v, 'start');
      label(0, 0, title, 'middle', `transform="translate(${w - 5} ${this.top + this.height / 2}) rotate(-90)"`);
    }

    mark(frame) {
      if (!this.data || !$('mark')) return;
      const k = this.row(frame), px = this.px(this.data.x[k]), py = this.py(this.data.y[k]);
      $('mark').setAttribute('cx', px);
      $('mark').setAttribute('cy', py);
      $('mark-line').setAttribute('x1', px);
      $('mark-line').setAttribute('x2', px);
    }

    facts(frame) {
      if (!this.data) return [];
      const k = this.row(frame), { x, y, second, titles } = this.data;
      const named = (title, value) => {
        const [name, unit] = title.split(', ');
        return [name, `${unitText(value)}${unit ? ` ${unit}` : ''}`];
      };
      const list = [named(titles[1], x[k]), named(titles[2], y[k])].filter(([name]) => name !== 'time');
      return second ? list.concat([[titles[3], String(second[k])]]) : list;
    }
  }

  // ---------------------------------------------------------------- page

  function middle(series) {
    // Where nearly all segments are in all frames: torn fibres may have flown far.
    const samples = [[], [], []], every = Math.max(1, Math.floor(series.count * series.frames.length / 60000));
    series.frames.forEach((_, frame) => {
      const x = series.position(frame);
      for (let i = frame % every; i < series.count; i += every) for (let d = 0; d < 3; d++) samples[d].push(x[3 * i + d]);
    });
    const range = samples.map((list) => {
      list.sort((p, q) => p - q);
      return [list[Math.floor(0.01 * (list.length - 1))], list[Math.ceil(0.99 * (list.length - 1))]];
    });
    const size = range.map(([low, high]) => high - low);
    return [range.map(([low, high]) => (low + high) / 2),
      0.5 * Math.hypot(...size) * 0.72 + 2 * series.thickest];
  }

  class Page {
    constructor() {
      this.view = $('view');
      this.scene = new THREE.Scene();
      this.camera = new THREE.PerspectiveCamera(28, 1, 1, 1e5);
      this.renderer = new THREE.WebGLRenderer({ canvas: $('canvas'), antialias: true, alpha: true,
        // A picture taken of the page at any moment shows the fabric.
        preserveDrawingBuffer: true });
      this.renderer.setPixelRatio(Math.min(devicePixelRatio || 1, 2));
      this.orbit = new Orbit(this.camera, this.view, () => this.ask());
      this.curve = new Curve($('curve'), (frame) => this.show(frame));
      this.listen();
      this.resize();
      this.choose();
    }

    get series() { return all[state.series]; }

    // What stands behind the # of the address: series, frame, colour, theme.
    choose() {
      const wanted = hash();
      let k = all.findIndex((s) => s.name === wanted.get('series'));
      if (k < 0) k = all.reduce((best, s, i) => (s.curve && s.curve.second ? i : best), all.length - 1);
      state.colour = wanted.get('colour') || state.colour;
      if (wanted.get('theme')) root.dataset.theme = wanted.get('theme');
      this.open(k);
      this.show(Number(wanted.get('frame')) || 0);
      this.draw();
    }

    open(k) {
      state.series = k;
      if (this.tubes) this.tubes.dispose(this.scene);
      if (this.lines) this.scene.remove(this.lines);
      const s = this.series;
      this.tubes = new Tubes(s, this.scene);
      this.lines = this.boxLines(s);
      if (this.lines) this.scene.add(this.lines);
      $('series').value = String(k);
      $('slider').max = String(s.frames.length - 1);
      const list = choices(s);
      if (!list.some(([name]) => name === state.colour)) state.colour = list[0][0];
      $('colour').innerHTML = list.map(([name, title]) => `<option value="${name}">${title.split(',')[0]}</option>`).join('');
      $('colour').value = state.colour;
      this.orbit.fit(...middle(s));
      this.curve.show(s);
      this.show(0);
    }

    boxLines(s) {
      if (!s.periodic.some(Boolean)) return null;
      const ends = new THREE.BufferGeometry();
      ends.setAttribute('position', new THREE.BufferAttribute(s.edges(0), 3));
      const lines = new THREE.LineSegments(ends,
        new THREE.LineBasicMaterial({ color: 0x8a94a0, transparent: true, opacity: 0.45 }));
      lines.frustumCulled = false;
      return lines;
    }

    show(frame) {
      const s = this.series;
      state.frame = Math.max(0, Math.min(s.frames.length - 1, Math.round(frame)));
      $('key').innerHTML = this.tubes.update(state.frame, state.colour);
      if (this.lines) {
        const ends = this.lines.geometry.attributes.position;
        ends.array.set(s.edges(state.frame));
        ends.needsUpdate = true;
      }
      $('slider').value = String(state.frame);
      const now = s.frames[state.frame];
      $('now').innerHTML = `${now.time}<small>step ${now.step.toLocaleString('en')}</small>`;
      const rows = [['snapshot', `${state.frame + 1} of ${s.frames.length}`], ['time', now.time], ...this.curve.facts(state.frame)];
      if (!rows.some(([name]) => name === 'broken bonds')) rows.push(['broken bonds', now.broken]);
      $('state').innerHTML = rows.map(([name, value]) => `<dt>${name}</dt><dd>${value}</dd>`).join('');
      this.curve.mark(state.frame);
      this.ask();
    }

    ask() {
      if (this.asked) return;
      this.asked = true;
      requestAnimationFrame(() => { this.asked = false; this.draw(); });
    }

    draw() {
      if (!this.tubes) return;
      const u = this.tubes.uniforms, o = this.orbit;
      u.haze.value.set(dark() ? '#191d23' : '#eef1f5');
      u.nearest.value = Math.max(0, o.distance - o.size);
      u.farthest.value = o.distance + 1.2 * o.size;
      this.renderer.render(this.scene, this.camera);
      root.dataset.frame = state.frame;
      root.dataset.ready = 'yes';
    }

    resize() {
      const w = this.view.clientWidth, h = this.view.clientHeight;
      if (this.camera.aspect === w / h && this.width === w) return;
      this.width = w;
      this.renderer.setSize(w, h, false);
      this.camera.aspect = w / h;
      this.camera.updateProjectionMatrix();
      // A new size empties the canvas.
      if (this.tubes) { this.curve.draw(); this.draw(); }
    }

    play(on) {
      state.playing = on;
      $('play').textContent = on ? '❚❚' : '▶';
      clearInterval(this.timer);
      if (!on) return;
      const pause = Math.max(60, Math.min(250, 6000 / this.series.frames.length));
      this.timer = setInterval(() => this.show((state.frame + 1) % this.series.frames.length), pause);
    }

    recolour(name) {
      state.colour = name;
      $('colour').value = name;
      this.show(state.frame);
    }

    key(e) {
      if (e.ctrlKey || e.metaKey || e.altKey || /^(SELECT|INPUT)$/.test(e.target.tagName) && e.key !== ' ') return;
      const list = choices(this.series).map(([name]) => name), at = list.indexOf(state.colour);
      const action = {
        ArrowRight: () => this.show(state.frame + 1), ArrowLeft: () => this.show(state.frame - 1),
        ArrowUp: () => this.recolour(list[(at + list.length - 1) % list.length]),
        ArrowDown: () => this.recolour(list[(at + 1) % list.length]),
        Home: () => this.show(0), End: () => this.show(Infinity),
        ' ': () => this.play(!state.playing), h: () => this.orbit.fit(...middle(this.series)),
      }[e.key];
      if (!action || (e.key === ' ' && e.target.tagName === 'BUTTON')) return;
      e.preventDefault();
      action();
    }

    listen() {
      $('series').innerHTML = all.map((s, k) => `<option value="${k}">${s.name}</option>`).join('');
      $('pick-series').hidden = all.length < 2;
      $('series').addEventListener('change', (e) => { this.play(false); this.open(Number(e.target.value)); e.target.blur(); });
      $('colour').addEventListener('change', (e) => { this.recolour(e.target.value); e.target.blur(); });
      $('slider').addEventListener('input', (e) => this.show(Number(e.target.value)));
      $('play').addEventListener('click', () => this.play(!state.playing));
      $('home').addEventListener('click', () => this.orbit.fit(...middle(this.series)));
      addEventListener('keydown', (e) => this.key(e));
      addEventListener('hashchange', () => this.choose());
      new ResizeObserver(() => requestAnimationFrame(() => this.resize())).observe(this.view);
      matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.show(state.frame));
    }
  }

  let page = null;
  $('theme').addEventListener('click', () => {
    root.dataset.theme = dark() ? 'light' : 'dark';
    if (page) page.show(state.frame);
  });
  if (!all.length) {
    root.dataset.ready = 'yes';
    return;
  }
  try {
    page = new Page();
  } catch (error) {
    fail(/WebGL/i.test(error.message) ? 'This browser has no WebGL, so the 3-D view stays empty.' : error.message);
  }
})();
