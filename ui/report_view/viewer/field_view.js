// The interactive view of a planned field in report.html: layers, views, and the opening from closed to planned. The
// page holds one <div class="field-view" data-scene="ID"> per field, and the scene as JSON in the script of this id.
// Positions are mm, patient LPS.

import '@kitware/vtk.js/Rendering/Profiles/Geometry';
import vtkActor from '@kitware/vtk.js/Rendering/Core/Actor';
import vtkAnnotatedCubeActor from '@kitware/vtk.js/Rendering/Core/AnnotatedCubeActor';
import vtkCellArray from '@kitware/vtk.js/Common/Core/CellArray';
import vtkDataArray from '@kitware/vtk.js/Common/Core/DataArray';
import vtkGenericRenderWindow from '@kitware/vtk.js/Rendering/Misc/GenericRenderWindow';
import vtkMapper from '@kitware/vtk.js/Rendering/Core/Mapper';
import vtkOrientationMarkerWidget from '@kitware/vtk.js/Interaction/Widgets/OrientationMarkerWidget';
import vtkPolyData from '@kitware/vtk.js/Common/DataModel/PolyData';
import vtkSphereSource from '@kitware/vtk.js/Filters/Sources/SphereSource';

// ---- the scene's numbers --------------------------------------------------------------------------------------------

function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) {
    bytes[i] = text.charCodeAt(i);
  }
  return bytes.buffer;
}

// Positions are steps of a grid over the scene's box.
function positionsOf(base64, box) {
  const steps = new Uint16Array(bytesOf(base64));
  const positions = new Float32Array(steps.length);
  for (let i = 0; i < steps.length; ++i) {
    positions[i] = box.low[i % 3] + (steps[i] / 65535) * (box.high[i % 3] - box.low[i % 3]);
  }
  return positions;
}

function cellsOf(base64) {
  const corners = new Uint32Array(bytesOf(base64));
  const cells = new Uint32Array((corners.length / 3) * 4);
  for (let t = 0; t < corners.length / 3; ++t) {
    cells.set([3, corners[3 * t], corners[3 * t + 1], corners[3 * t + 2]], 4 * t);
  }
  return cells;
}

// Means of the triangles' normals at each corner, weighted by area.
function normalsOf(positions, cells) {
  const normals = new Float32Array(positions.length);
  for (let c = 0; c < cells.length; c += 4) {
    const [a, b, d] = [3 * cells[c + 1], 3 * cells[c + 2], 3 * cells[c + 3]];
    const [ux, uy, uz] = [positions[b] - positions[a], positions[b + 1] - positions[a + 1], positions[b + 2] - positions[a + 2]];
    const [vx, vy, vz] = [positions[d] - positions[a], positions[d + 1] - positions[a + 1], positions[d + 2] - positions[a + 2]];
    const normal = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    for (const corner of [a, b, d]) {
      for (let k = 0; k < 3; ++k) {
        normals[corner + k] += normal[k];
      }
    }
  }
  for (let i = 0; i < normals.length; i += 3) {
    const length = Math.hypot(normals[i], normals[i + 1], normals[i + 2]) || 1;
    for (let k = 0; k < 3; ++k) {
      normals[i + k] /= length;
    }
  }
  return normals;
}

// ---- how much is seen -----------------------------------------------------------------------------------------------

// From 0 to 1, dark to bright: after viridis, so that it reads without colours, too.
const SCALE = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];

function colorOf(share) {
  const at = Math.min(Math.max(share, 0), 1) * (SCALE.length - 1);
  const low = Math.min(Math.floor(at), SCALE.length - 2);
  return SCALE[low].map((value, k) => value + (at - low) * (SCALE[low + 1][k] - value));
}

function colorsOf(base64) {
  const shares = new Uint8Array(bytesOf(base64));
  const colors = new Uint8Array(3 * shares.length);
  shares.forEach((share, n) => colors.set(colorOf(share / 255), 3 * n));
  return colors;
}

// The eyes over which the mean is taken, each in the colour of the share that it sees.
function makeEyes(eyes) {
  return eyes.map(([x, y, z, share]) => {
    const sphere = vtkSphereSource.newInstance({ center: [x, y, z], radius: 7, thetaResolution: 12, phiResolution: 12 });
    const mapper = vtkMapper.newInstance();
    mapper.setInputConnection(sphere.getOutputPort());
    const actor = vtkActor.newInstance();
    actor.setMapper(mapper);
    actor.getProperty().setColor(...colorOf(share).map((value) => value / 255));
    return actor;
  });
}

// ---- one surface ----------------------------------------------------------------------------------------------------

function makeSurface(item, box) {
  const opened = positionsOf(item.opened, box);
  const rest = item.rest ? positionsOf(item.rest, box) : null;
  const cells = cellsOf(item.triangles);
  const points = Float32Array.from(opened);
  const data = vtkPolyData.newInstance();
  data.getPoints().setData(points, 3);
  data.setPolys(vtkCellArray.newInstance({ values: cells }));
  const setNormals = () =>
    data.getPointData().setNormals(
      vtkDataArray.newInstance({ name: 'normals', numberOfComponents: 3, values: normalsOf(points, cells) })
    );
  setNormals();
  const mapper = vtkMapper.newInstance({ scalarVisibility: false });
  if (item.seen) {
    data.getPointData().setScalars(
      vtkDataArray.newInstance({ name: 'seen', numberOfComponents: 3, values: colorsOf(item.seen) })
    );
    mapper.setColorModeToDirectScalars();
  }
  mapper.setInputData(data);
  const actor = vtkActor.newInstance();
  actor.setMapper(mapper);
  const property = actor.getProperty();
  property.setColor(...item.color);
  property.setOpacity(item.opacity);
  property.setAmbient(0.15);
  property.setDiffuse(0.85);
  property.setSpecular(item.layer === 'steel' ? 0.5 : 0.08);
  property.setSpecularPower(20);
  return {
    layer: item.layer,
    actor,
    showSeen(shown) {
      mapper.setScalarVisibility(shown && Boolean(item.seen));
    },
    // Moves the surface from rest (0) to the planned opening (1).
    open(share) {
      if (!rest) {
        return;
      }
      for (let i = 0; i < points.length; ++i) {
        points[i] = rest[i] + share * (opened[i] - rest[i]);
      }
      data.getPoints().setData(points, 3);
      data.getPoints().modified();
      setNormals();
      data.modified();
    },
  };
}

// ---- the view of one field ------------------------------------------------------------------------------------------

function addCube(interactor) {
  const cube = vtkAnnotatedCubeActor.newInstance();
  cube.setDefaultStyle({ faceColor: '#e8e4da', fontColor: '#222', edgeThickness: 0.05, edgeColor: '#888', resolution: 128 });
  const letters = { XPlus: 'L', XMinus: 'R', YPlus: 'P', YMinus: 'A', ZPlus: 'S', ZMinus: 'I' };
  for (const [face, text] of Object.entries(letters)) {
    cube[`set${face}FaceProperty`]({ text });
  }
  const marker = vtkOrientationMarkerWidget.newInstance({ actor: cube, interactor });
  marker.setEnabled(true);
  marker.setViewportCorner(vtkOrientationMarkerWidget.Corners.BOTTOM_RIGHT);
  marker.setViewportSize(0.12);
  marker.setMinPixelSize(60);
  marker.setMaxPixelSize(110);
}

function button(parent, text, onClick) {
  const made = document.createElement('button');
  made.type = 'button';
  made.textContent = text;
  made.addEventListener('click', onClick);
  parent.appendChild(made);
  return made;
}

// The wheel scrolls the page, until the reader has clicked into the view; it then zooms until the pointer leaves.
function letWheelScroll(canvas) {
  let taken = false;
  canvas.addEventListener('pointerdown', () => { taken = true; }, true);
  canvas.addEventListener('pointerleave', () => { taken = false; });
  canvas.addEventListener('wheel', (event) => taken || event.stopPropagation(), true);
}

function checkbox(parent, text, checked, onChange) {
  const box = document.createElement('input');
  Object.assign(box, { type: 'checkbox', checked });
  box.addEventListener('change', () => onChange(box.checked));
  const label = document.createElement('label');
  label.append(box, ` ${text}`);
  parent.appendChild(label);
}

// The target in the colours of the number of eyes that see it, and the eyes in those of the share that they see.
function addSeen(controls, renderer, surfaces, eyes, update) {
  const balls = makeEyes(eyes.places.map(([x, y, z, share]) => [x, y, z, share / eyes.largest_share]));
  balls.forEach((ball) => {
    ball.setVisibility(false);
    renderer.addActor(ball);
  });
  const key = document.createElement('div');
  key.className = 'field-view-hint';
  key.hidden = true;
  key.textContent = `The target is dark where none of the ${eyes.places.length} eyes of the cone sees it, and bright where `
    + `${eyes.most_that_see} of them do. A ball is one of these eyes: dark where it sees nothing of the target, bright `
    + `where it sees ${(100 * eyes.largest_share).toFixed(1)} % of its area.`;
  checkbox(controls, 'what eyes see', false, (checked) => {
    surfaces.forEach((surface) => surface.showSeen(checked));
    balls.forEach((ball) => ball.setVisibility(checked));
    key.hidden = !checked;
    update();
  });
  controls.appendChild(key);
}

function show(host, scene) {
  host.textContent = '';
  const controls = document.createElement('div');
  controls.className = 'field-view-controls';
  const canvas = document.createElement('div');
  canvas.className = 'field-view-canvas';
  const hint = document.createElement('div');
  hint.className = 'field-view-hint';
  hint.textContent = 'Drag turns, Shift and drag moves, the wheel zooms after a click.';
  host.append(controls, canvas, hint);
  letWheelScroll(canvas);

  const view = vtkGenericRenderWindow.newInstance({ background: [0.1, 0.12, 0.14] });
  view.setContainer(canvas);
  const renderer = view.getRenderer();
  const window_ = view.getRenderWindow();
  const surfaces = scene.surfaces.map((item) => makeSurface(item, scene.box));
  surfaces.forEach((surface) => renderer.addActor(surface.actor));

  const look = (camera) => {
    const active = renderer.getActiveCamera();
    active.setFocalPoint(...camera.aim);
    active.setPosition(...camera.eye);
    active.setViewUp(...camera.up);
    active.setViewAngle(camera.view_angle_deg);
    renderer.resetCameraClippingRange();
    window_.render();
  };

  const hidden = new Set();
  let share = 1;
  const update = () => {
    for (const surface of surfaces) {
      // Steel stands where the plan leaves it; on the way there it is not drawn.
      surface.actor.setVisibility(!hidden.has(surface.layer) && (surface.layer !== 'steel' || share === 1));
    }
    renderer.resetCameraClippingRange();
    window_.render();
  };

  button(controls, 'Surgeon’s eye', () => look(scene.surgeon));
  button(controls, 'From outside', () => look(scene.outside));
  const slider = document.createElement('input');
  Object.assign(slider, { type: 'range', min: 0, max: 100, value: 100 });
  const opening = document.createElement('label');
  const amount = document.createElement('span');
  opening.append('opening ', slider, ' ', amount);
  const open = () => {
    share = slider.value / 100;
    amount.textContent = `${slider.value} %`;
    surfaces.forEach((surface) => surface.open(share));
    update();
  };
  slider.addEventListener('input', open);
  button(controls, 'Before / after', () => {
    slider.value = share > 0.5 ? 0 : 100;
    open();
  });
  controls.appendChild(opening);
  for (const layer of scene.layers) {
    checkbox(controls, layer.name, true, (checked) => {
      checked ? hidden.delete(layer.key) : hidden.add(layer.key);
      update();
    });
  }
  if (scene.eyes) {
    addSeen(controls, renderer, surfaces, scene.eyes, update);
  }

  view.resize();
  addCube(view.getInteractor());
  const resizing = new ResizeObserver(() => view.resize());
  resizing.observe(canvas);
  open();
  look(scene.surgeon);
  host.dataset.state = 'shown';
  shown.push({
    host,
    close() {
      resizing.disconnect();
      view.delete();
    },
  });
}

function start(host) {
  giveWay();
  try {
    show(host, JSON.parse(document.getElementById(host.dataset.scene).textContent));
  } catch (error) {
    host.dataset.state = 'failed';
    host.textContent = `This browser shows no 3D (${error.message}). The pictures below show the same field.`;
  }
}

// A browser holds few views at once: the one that was made first gives way, and can be called again.
const MOST_VIEWS = 8;
const shown = [];

function giveWay() {
  if (shown.length < MOST_VIEWS) {
    return;
  }
  const { host, close } = shown.shift();
  close();
  host.textContent = '';
  host.dataset.state = 'closed';
  button(host, 'Show the view again', () => start(host));
}

// A view is made when the reader comes to it.
const observer = new IntersectionObserver((entries) => {
  for (const entry of entries.filter((one) => one.isIntersecting)) {
    observer.unobserve(entry.target);
    start(entry.target);
  }
}, { rootMargin: '200px' });
document.querySelectorAll('.field-view').forEach((host) => observer.observe(host));
