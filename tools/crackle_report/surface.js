// Draws crack surfaces that can be turned and played in time, in place of their pictures, where there is WebGL.
for (const figure of document.querySelectorAll("figure.surface")) {
  const bytes = (name) => Uint8Array.from(atob(figure.dataset[name]), (letter) => letter.charCodeAt(0));
  const floats = (name) => new Float32Array(bytes(name).buffer);
  const stage = figure.querySelector(".stage");
  let renderer;
  try {
    renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true, canvas: stage.querySelector("canvas") });
  } catch (error) {
    continue;  // the picture stays
  }
  const corner = floats("corner"), time = floats("time"), colour = bytes("colour"), line = floats("line");
  const facets = time.length;

  // Two triangles for each quadrilateral, with their own corners, so that each keeps its colour.
  const position = new Float32Array(facets * 18), shade = new Float32Array(facets * 18);
  const order = [0, 1, 2, 0, 2, 3];
  for (let f = 0; f < facets; ++f)
    for (let k = 0; k < 6; ++k)
      for (let c = 0; c < 3; ++c) {
        position[18 * f + 3 * k + c] = corner[12 * f + 3 * order[k] + c];
        shade[18 * f + 3 * k + c] = colour[3 * f + c] / 255;
      }
  const surface = new THREE.BufferGeometry();
  surface.setAttribute("position", new THREE.BufferAttribute(position, 3));
  surface.setAttribute("color", new THREE.BufferAttribute(shade, 3));
  surface.computeVertexNormals();
  const edges = new THREE.BufferGeometry();
  edges.setAttribute("position", new THREE.BufferAttribute(line, 3));

  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0xffffff);
  scene.add(new THREE.Mesh(surface, new THREE.MeshLambertMaterial({ vertexColors: true, side: THREE.DoubleSide })));
  scene.add(new THREE.LineSegments(edges, new THREE.LineBasicMaterial({ color: 0x343a40 })));
  scene.add(new THREE.AmbientLight(0xffffff, 0.65));

  surface.computeBoundingSphere();
  const { center, radius } = surface.boundingSphere;
  const camera = new THREE.PerspectiveCamera(35, 1, radius / 100, radius * 100);
  camera.up.set(0, 0, 1);
  camera.position.set(center.x + 2.6 * radius, center.y - 1.3 * radius, center.z + 1.1 * radius);  // y to the right
  const light = new THREE.DirectionalLight(0xffffff, 0.5);
  camera.add(light);
  scene.add(camera);
  const controls = new THREE.OrbitControls(camera, renderer.domElement);
  controls.target.copy(center);

  const draw = () => renderer.render(scene, camera);
  const resize = () => {
    const width = figure.clientWidth, height = Math.round(Math.min(0.65 * width, 520));
    renderer.setPixelRatio(window.devicePixelRatio);
    renderer.setSize(width, height);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    draw();
  };

  // Facets are in order of opening.
  const slider = figure.querySelector("input"), play = figure.querySelector("button"), clock = figure.querySelector("output");
  const last = time[facets - 1];
  const show = (now) => {
    let open = 0;
    for (let step = 1 << 30; step > 0; step >>= 1) if (open + step <= facets && time[open + step - 1] <= now) open += step;
    surface.setDrawRange(0, 6 * open);
    clock.textContent = `t = t₀ + ${now.toFixed(0)} ${figure.dataset.unit}`;
    draw();
  };
  slider.max = last;
  slider.step = last / 200;
  slider.value = last;
  slider.addEventListener("input", () => show(Number(slider.value)));
  let started = null;
  const seconds = 6;
  const frame = (now) => {
    if (started === null) return;
    const share = (now - started) / (1000 * seconds);
    slider.value = Math.min(share, 1) * last;
    show(Number(slider.value));
    if (share < 1) requestAnimationFrame(frame);
    else stop();
  };
  const stop = () => {
    started = null;
    play.textContent = "Play";
  };
  play.addEventListener("click", () => {
    if (started !== null) return stop();
    const share = Number(slider.value) < last ? Number(slider.value) / last : 0;
    started = performance.now() - 1000 * seconds * share;
    play.textContent = "Pause";
    requestAnimationFrame(frame);
  });

  figure.classList.add("live");
  controls.addEventListener("change", draw);
  controls.update();
  window.addEventListener("resize", resize);
  resize();
  show(last);
}
