// Runs a scene in Box2D 3 as npm's box2d3-wasm has it: node peer.mjs FOLDER SCENE.json; docs/crosscheck.md, "Box2D 3".
// SPDX-License-Identifier: MIT
//
// FOLDER holds node_modules. SCENE.json is what tool/box2d3/box2d3_scene.cpp writes, in units of Box2D. The answer is
// one JSON value a line: a head, a line for each reported tick, and an end. Numbers of Box2D are floats; nine digits
// read back to the same float. A scene that Box2D 3 cannot represent gives one line {"refused": why}.
import fs from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';

const lines = [];
let lineSize = 0;
function flush() {
  if (lines.length > 0) fs.writeSync(1, lines.join('\n') + '\n');
  lines.length = 0;
  lineSize = 0;
}
function answer(value) {
  const line = JSON.stringify(value);
  lines.push(line);
  lineSize += line.length;
  if (lineSize > 60000) flush();
}
const brief = (value) => (Number.isFinite(value) ? Number(value.toPrecision(9)) : null);

// Processor time of this process: what else runs on the machine is not in it.
function processorMs() {
  const { user, system } = process.cpuUsage();
  return (user + system) / 1000;
}

class Refused extends Error {}

async function loadBox2d(folder) {
  const home = path.join(path.resolve(folder), 'node_modules', 'box2d3-wasm');
  const description = JSON.parse(fs.readFileSync(path.join(home, 'package.json'), 'utf8'));
  const factory = (await import(pathToFileURL(path.join(home, description.module)).href)).default;
  return { box2d: await factory({ pthreadCount: 0 }), version: description.version };
}

const mixRules = {
  sqrt: (a, b) => Math.sqrt(a * b),
  max: (a, b) => Math.max(a, b),
  min: (a, b) => Math.min(a, b),
  average: (a, b) => (a + b) / 2,
};

class World {
  constructor(box2d, scene) {
    this.box2d = box2d;
    this.scene = scene;
    this.bodies = [];  // {id, kind, handle, local centre}; null once removed
    this.idOf = new Map();  // by index1 of Box2D's body
    this.clampedTick = 0;
    this.stepTimeMs = 0;
    const definition = box2d.b2DefaultWorldDef();
    definition.gravity.Set(scene.gravity[0], scene.gravity[1]);
    definition.enableSleep = false;
    definition.enableContinuous = scene.continuous;
    definition.restitutionThreshold = scene.restitution_threshold;
    definition.workerCount = 0;
    this.speedMax = 0.9999 * definition.maximumLinearSpeed;
    this.stepTime = scene.dt / scene.steps_per_tick;
    this.spinMax = 0.9999 * 0.25 * Math.PI * scene.substeps / this.stepTime;  // Box2D cuts to 45 degrees a substep
    this.world = box2d.b2CreateWorld(definition);
    definition.delete();
    if (scene.friction_mix !== 'sqrt') {
      const rule = mixRules[scene.friction_mix];
      box2d.b2World_SetFrictionCallback(this.world, (a, idA, b) => rule(a, b));
    }
    if (scene.restitution_mix !== 'max') {
      const rule = mixRules[scene.restitution_mix];
      box2d.b2World_SetRestitutionCallback(this.world, (a, idA, b) => rule(a, b));
    }
    scene.bodies.forEach((body, id) => this.addBody(body, id));
    scene.joints.forEach((joint, index) => this.addJoint(joint, index));
  }

  destroy() {
    this.box2d.b2DestroyWorld(this.world);
  }

  point(values) {
    return new this.box2d.b2Vec2(values[0], values[1]);
  }

  addBody(body, id) {
    const box2d = this.box2d;
    const definition = box2d.b2DefaultBodyDef();
    definition.type = box2d.b2BodyType[`b2_${body.type}Body`];
    definition.position.Set(body.position[0], body.position[1]);
    definition.rotation.SetAngle(body.angle);
    definition.linearDamping = body.linear_damping;
    definition.angularDamping = body.angular_damping;
    definition.gravityScale = body.gravity_scale;
    definition.isBullet = body.bullet;
    definition.enableSleep = false;
    const handle = box2d.b2CreateBody(this.world, definition);
    definition.delete();
    body.shapes.forEach((shape, index) => this.addShape(handle, shape, `/bodies/${id}/shapes/${index}`));
    if (body.type === 'dynamic') {
      if (body.fixed_rotation) {
        const locks = new box2d.b2MotionLocks();
        locks.linearX = false;
        locks.linearY = false;
        locks.angularZ = true;
        box2d.b2Body_SetMotionLocks(handle, locks);
      }
      const mass = new box2d.b2MassData();
      mass.mass = body.mass;
      mass.rotationalInertia = body.inertia;  // about the centre of mass
      mass.center.Set(body.center[0], body.center[1]);
      box2d.b2Body_SetMassData(handle, mass);
      mass.delete();
    }
    if (body.type !== 'static') {
      box2d.b2Body_SetLinearVelocity(handle, this.point(body.velocity));
      box2d.b2Body_SetAngularVelocity(handle, body.spin);
    }
    this.idOf.set(handle.index1, id);
    this.bodies.push({ id, handle, isStatic: body.type === 'static', isDynamic: body.type === 'dynamic', center: body.center });
  }

  addShape(handle, shape, place) {
    const box2d = this.box2d;
    if (shape.kind === 'chain') {
      this.addChain(handle, shape);
      return;
    }
    const definition = box2d.b2DefaultShapeDef();
    definition.updateBodyMass = false;
    this.setMaterial(definition.material, shape);
    this.setFilter(definition.filter, shape);
    if (shape.kind === 'circle') {
      const circle = new box2d.b2Circle();
      circle.center.Set(shape.center[0], shape.center[1]);
      circle.radius = shape.radius;
      box2d.b2CreateCircleShape(handle, definition, circle);
    } else if (shape.kind === 'box') {
      const polygon = box2d.b2MakeOffsetRoundedBox(
        shape.half_size[0], shape.half_size[1], this.point(shape.center), box2d.b2MakeRot(shape.angle), shape.radius);
      box2d.b2CreatePolygonShape(handle, definition, polygon);
    } else if (shape.kind === 'capsule') {
      const capsule = new box2d.b2Capsule();
      capsule.center1.Set(shape.points[0][0], shape.points[0][1]);
      capsule.center2.Set(shape.points[1][0], shape.points[1][1]);
      capsule.radius = shape.radius;
      box2d.b2CreateCapsuleShape(handle, definition, capsule);
    } else if (shape.kind === 'segment') {
      const segment = new box2d.b2Segment();
      segment.point1.Set(shape.points[0][0], shape.points[0][1]);
      segment.point2.Set(shape.points[1][0], shape.points[1][1]);
      box2d.b2CreateSegmentShape(handle, definition, segment);
    } else if (shape.kind === 'polygon') {
      const hull = box2d.b2ComputeHull(shape.points.map((each) => this.point(each)));
      if (hull.count !== shape.points.length)
        throw new Refused(
          `${place}/vertices: Box2D 3 welds or drops some: found ${hull.count} left, expected ${shape.points.length}`);
      box2d.b2CreatePolygonShape(handle, definition, box2d.b2MakePolygon(hull, shape.radius));
    } else {
      throw new Error(`unknown shape: found ${shape.kind}`);
    }
    definition.delete();
  }

  addChain(handle, shape) {
    const box2d = this.box2d;
    const definition = box2d.b2DefaultChainDef();
    this.setFilter(definition.filter, shape);
    definition.isLoop = shape.loop;
    definition.SetPoints(shape.points.map((each) => this.point(each)));
    const chain = box2d.b2CreateChain(handle, definition);
    definition.delete();
    // The material of a chain's definition does not reach its segments in box2d3-wasm 5.2.0.
    const material = box2d.b2DefaultSurfaceMaterial();
    this.setMaterial(material, shape);
    for (const segment of box2d.b2Chain_GetSegments(chain, shape.points.length))
      box2d.b2Shape_SetSurfaceMaterial(segment, material);
    material.delete();
  }

  setMaterial(material, shape) {
    material.friction = shape.friction;
    material.restitution = shape.restitution;
    material.rollingResistance = shape.rolling_resistance;
    material.tangentSpeed = shape.tangent_speed;
  }

  setFilter(filter, shape) {
    filter.categoryBits = shape.category;
    filter.maskBits = shape.mask;
    filter.groupIndex = shape.group;
  }

  addJoint(joint, index) {
    const box2d = this.box2d;
    const name = joint.kind[0].toUpperCase() + joint.kind.slice(1);
    const definition = box2d[`b2Default${name}JointDef`]();
    const base = definition.base;
    base.bodyIdA = this.bodies[joint.body_a].handle;
    base.bodyIdB = this.bodies[joint.body_b].handle;
    base.collideConnected = joint.collide_connected;
    base.localFrameA.p.Set(joint.anchor_a[0], joint.anchor_a[1]);
    base.localFrameB.p.Set(joint.anchor_b[0], joint.anchor_b[1]);
    base.localFrameA.q.SetAngle(joint.angle_a);
    base.localFrameB.q.SetAngle(joint.angle_b);
    for (const [key, value] of Object.entries(joint.fields)) {
      if (!(key in definition)) throw new Error(`/joints/${index}: Box2D 3 has no field ${key}`);
      definition[key] = value;
    }
    box2d[`b2Create${name}Joint`](this.world, definition);
    definition.delete();
  }

  // One tick. The time of the steps alone is added to stepTimeMs.
  step(tick) {
    const { b2World_Step: step } = this.box2d;
    for (let i = 0; i < this.scene.steps_per_tick; ++i) {
      const start = processorMs();
      step(this.world, this.stepTime, this.scene.substeps);
      this.stepTimeMs += processorMs() - start;
    }
    this.look(tick, this.scene.bounds);
  }

  // Finds bodies whose motion Box2D cut, and removes those that left the bounds.
  look(tick, bounds) {
    const box2d = this.box2d;
    for (let i = 0; i < this.bodies.length; ++i) {
      const body = this.bodies[i];
      if (body === null || body.isStatic) continue;
      if (this.clampedTick === 0) {
        const velocity = box2d.b2Body_GetLinearVelocity(body.handle);
        const speed = Math.hypot(velocity.x, velocity.y);
        velocity.delete();
        if (speed >= this.speedMax || Math.abs(box2d.b2Body_GetAngularVelocity(body.handle)) >= this.spinMax)
          this.clampedTick = tick;
      }
      if (bounds === null) continue;
      const local = this.point(body.center);
      const center = box2d.b2Body_GetWorldPoint(body.handle, local);
      const isInside =
        center.x >= bounds[0] && center.y >= bounds[1] && center.x <= bounds[2] && center.y <= bounds[3];
      local.delete();
      center.delete();
      if (isInside) continue;
      this.idOf.delete(body.handle.index1);
      box2d.b2DestroyBody(body.handle);
      this.bodies[i] = null;
    }
  }

  bodyNumbers() {
    const box2d = this.box2d;
    const numbers = [];
    for (const body of this.bodies) {
      if (body === null || body.isStatic) continue;
      const at = box2d.b2Body_GetPosition(body.handle);
      const rotation = box2d.b2Body_GetRotation(body.handle);
      const velocity = box2d.b2Body_GetLinearVelocity(body.handle);
      numbers.push(
        body.id, brief(at.x), brief(at.y), brief(rotation.c), brief(rotation.s), brief(velocity.x), brief(velocity.y),
        brief(box2d.b2Body_GetAngularVelocity(body.handle)));
      at.delete();
      rotation.delete();
      velocity.delete();
    }
    return numbers;
  }

  // For each touching pair: ids, normal from A to B, number of points, and for two points place, separation and force.
  contactNumbers() {
    const box2d = this.box2d;
    const substep = this.stepTime / this.scene.substeps;
    const slop = 0.005;
    const numbers = [];
    for (const body of this.bodies) {
      if (body === null || !body.isDynamic) continue;
      const capacity = box2d.b2Body_GetContactCapacity(body.handle);
      if (capacity === 0) continue;
      const contacts = box2d.b2Body_GetContactData(body.handle, capacity);
      for (const contact of contacts) {
        const a = this.idOf.get(box2d.b2Shape_GetBody(contact.shapeIdA).index1);
        const b = this.idOf.get(box2d.b2Shape_GetBody(contact.shapeIdB).index1);
        const other = a === body.id ? b : a;
        if (a !== undefined && b !== undefined && !(this.bodies[other].isDynamic && other < body.id))
          this.addContact(numbers, a, b, contact.manifold, substep, slop);
        contact.delete();
      }
    }
    return numbers;
  }

  // Box2D also lists points that are near each other only. Such a point has no impulse.
  addContact(numbers, a, b, manifold, substep, slop) {
    const points = [];
    for (let i = 0; i < manifold.pointCount; ++i) {
      const point = manifold.GetPoint(i);
      if (point.separation <= slop || point.normalImpulse > 0)
        points.push(
          brief(point.point.x), brief(point.point.y), brief(point.separation), point.normalImpulse / substep);
      point.delete();
    }
    if (points.length === 0) return;
    const count = points.length / 4;
    while (points.length < 8) points.push(0);
    numbers.push(a, b, brief(manifold.normal.x), brief(manifold.normal.y), count, ...points);
  }
}

function run(box2d, scene, report) {
  const world = new World(box2d, scene);
  for (let tick = 1; tick <= scene.ticks; ++tick) {
    world.step(tick);
    if (!report || tick % scene.body_interval !== 0) continue;
    const line = { tick, bodies: world.bodyNumbers() };
    const left = scene.ticks - tick;
    if (left < scene.contact_window && left % scene.contact_interval === 0) line.contacts = world.contactNumbers();
    answer(line);
  }
  const end = { done: true, clamped_tick: world.clampedTick, ms_per_tick: scene.ticks > 0 ? world.stepTimeMs / scene.ticks : 0 };
  world.destroy();
  return end;
}

try {
  const { box2d, version } = await loadBox2d(process.argv[2]);
  const scene = JSON.parse(fs.readFileSync(process.argv[3], 'utf8'));
  answer({ schema: 'ticktrue.box2d3/1', package: version });
  // The first run makes node compile all that it calls, so that the second one has its full speed.
  if (scene.warm_up) run(box2d, scene, false);
  answer(run(box2d, scene, true));
  flush();
  process.exit(0);
} catch (error) {
  if (error instanceof Refused) {
    lines.length = 0;
    answer({ refused: error.message });
    flush();
    process.exit(0);
  }
  console.error(`box2d3: ${error?.stack ?? error}`);
  process.exit(1);
}
