// Jolt as a peer, as WebAssembly.
import initJolt from "jolt-physics/wasm-compat";

import { Refused, World, rotate, serve, versionOf } from "./protocol.mjs";

const Jolt = await initJolt();

// Its capsules and cylinders are along y.
const FROM_Y = [Math.SQRT1_2, Math.SQRT1_2, 0, 0];
const UNLIMITED = 1e6; // m/s and rad/s
// Layers of objects.
const [STATIC, MOVING] = [0, 1];
// An object of the WebAssembly, for as long as `use` needs it.
function lend(made, use) {
  const result = use(made);
  Jolt.destroy(made);
  return result;
}
// The same for those that count who refers to them.
function counted(made, use) {
  made.AddRef();
  const result = use(made);
  made.Release();
  return result;
}
const vec = (v, use) => lend(new Jolt.Vec3(...v), use);
const setVec = (target, v) => target.Set(...v);
const setTurn = (target, [w, x, y, z]) => target.Set(x, y, z, w);

// As deep as its edges are rounded by default, and no deeper than a small shape allows.
const roundingOf = (least) => Math.min(0.05, least);

// Settings of the shape.
function shapeOf(shape) {
  const alongZ = (settings) => lend(new Jolt.Quat(FROM_Y[1], FROM_Y[2], FROM_Y[3], FROM_Y[0]), (q) =>
    vec([0, 0, 0], (zero) => new Jolt.RotatedTranslatedShapeSettings(zero, q, settings)));
  switch (shape.kind) {
    case "sphere": return new Jolt.SphereShapeSettings(shape.radius);
    case "box": {
      const rounding = roundingOf(Math.min(...shape.half_extents));
      return vec(shape.half_extents, (half) => new Jolt.BoxShapeSettings(half, rounding));
    }
    case "capsule": return alongZ(new Jolt.CapsuleShapeSettings(shape.half_length, shape.radius));
    case "cylinder":
      return alongZ(new Jolt.CylinderShapeSettings(shape.half_length, shape.radius,
                                                   roundingOf(Math.min(shape.half_length, shape.radius))));
    case "plane":
      return vec(shape.normal, (normal) => lend(new Jolt.Plane(normal, -shape.offset), (plane) =>
        new Jolt.PlaneShapeSettings(plane)));
    case "hull": {
      const settings = new Jolt.ConvexHullShapeSettings();
      for (const point of shape.points) vec(point, (p) => settings.mPoints.push_back(p));
      return settings;
    }
    case "mesh": {
      const triangles = new Jolt.TriangleList();
      triangles.resize(shape.indices.length / 3);
      shape.indices.forEach((index, place) => {
        const corner = triangles.at(Math.floor(place / 3)).get_mV(place % 3);
        [corner.x, corner.y, corner.z] = shape.points[index];
      });
      const settings = new Jolt.MeshShapeSettings(triangles);
      Jolt.destroy(triangles);
      return settings;
    }
    default: throw new Refused(`shapes of the kind ${shape.kind}`);
  }
}

function layers(settings) {
  const pairs = new Jolt.ObjectLayerPairFilterTable(2);
  pairs.EnableCollision(STATIC, MOVING);
  pairs.EnableCollision(MOVING, MOVING);
  const phases = new Jolt.BroadPhaseLayerInterfaceTable(2, 2);
  for (const layer of [STATIC, MOVING]) {
    lend(new Jolt.BroadPhaseLayer(layer), (phase) => phases.MapObjectToBroadPhaseLayer(layer, phase));
  }
  settings.mObjectLayerPairFilter = pairs;
  settings.mBroadPhaseLayerInterface = phases;
  settings.mObjectVsBroadPhaseLayerFilter = new Jolt.ObjectVsBroadPhaseLayerFilterTable(phases, 2, pairs, 2);
}

class JoltWorld extends World {
  constructor(scene) {
    super();
    this.scene = scene;
    const settings = new Jolt.JoltSettings();
    layers(settings);
    this.jolt = new Jolt.JoltInterface(settings);
    Jolt.destroy(settings);
    this.system = this.jolt.GetPhysicsSystem();
    this.interface = this.system.GetBodyInterface();
    this.held = new Map();
    this.gravity(...scene.gravity);
    this.groups = new Jolt.GroupFilterTable(scene.bodies.length);
    this.groups.AddRef();
    const still = { position: [0, 0, 0], orientation: [1, 0, 0, 0], mass: null };
    if (scene.ground) this.giveBody({ ...still, shape: { kind: "plane", normal: [0, 0, 1], offset: 0 } });
    this.bodies = scene.bodies.map((body, place) => this.giveBody(body, place));
    this.joints = scene.joints.map((joint) => this.giveJoint(joint));
    this.system.OptimizeBroadPhase();
  }

  giveBody(body, place) {
    const moves = body.mass !== null;
    const settings = new Jolt.BodyCreationSettings();
    counted(shapeOf(body.shape), (shape) => {
      const made = shape.Create();
      if (made.HasError()) throw new Refused(`a shape: ${made.GetError().c_str()}`);
      settings.SetShape(made.Get());
    });
    setVec(settings.mPosition, body.position);
    setTurn(settings.mRotation, body.orientation);
    settings.mMotionType = moves ? Jolt.EMotionType_Dynamic : Jolt.EMotionType_Static;
    settings.mObjectLayer = moves ? MOVING : STATIC;
    settings.mFriction = this.scene.friction;
    settings.mRestitution = this.scene.restitution;
    if (place !== undefined && this.scene.joints.length > 0) {
      settings.mCollisionGroup.SetGroupFilter(this.groups);
      settings.mCollisionGroup.SetGroupID(0);
      settings.mCollisionGroup.SetSubGroupID(place);
    }
    if (moves) this.giveMotion(settings, body);
    const made = this.interface.CreateBody(settings);
    Jolt.destroy(settings);
    this.interface.AddBody(made.GetID(), Jolt.EActivation_Activate);
    return made;
  }

  giveMotion(settings, body) {
    setVec(settings.mLinearVelocity, body.velocity);
    setVec(settings.mAngularVelocity, body.spin);
    settings.mLinearDamping = 0;
    settings.mAngularDamping = 0;
    settings.mMaxLinearVelocity = UNLIMITED;
    settings.mMaxAngularVelocity = UNLIMITED;
    settings.mApplyGyroscopicForce = true;
    settings.mAllowSleeping = false;
    settings.mOverrideMassProperties = Jolt.EOverrideMassProperties_MassAndInertiaProvided;
    const properties = settings.mMassPropertiesOverride;
    const [xx, yy, zz, xy, xz, yz] = body.tensor;
    properties.mMass = body.mass;
    [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]].forEach((column, place) =>
      vec(column, (v) => properties.mInertia.SetColumn3(place, v)));
  }

  giveJoint({ kind, a, b, in_a: inA, in_b: inB }) {
    const settings = kind === "ball" ? new Jolt.PointConstraintSettings()
      : kind === "hinge" ? new Jolt.HingeConstraintSettings() : new Jolt.SliderConstraintSettings();
    settings.mSpace = Jolt.EConstraintSpace_LocalToBodyCOM;
    const frames = [inA, inB].map((frame) => ({
      point: frame.position, axis: rotate(frame.orientation, [0, 0, 1]), normal: rotate(frame.orientation, [1, 0, 0]),
    }));
    frames.forEach(({ point, axis, normal }, place) => {
      setVec(settings[`mPoint${place + 1}`], point);
      if (kind === "ball") return;
      setVec(settings[`m${kind === "hinge" ? "Hinge" : "Slider"}Axis${place + 1}`], axis);
      setVec(settings[`mNormalAxis${place + 1}`], normal);
    });
    const first = a === null ? this.jolt.sGetFixedToWorldBody() : this.bodies[a];
    if (a !== null) this.groups.DisableCollision(a, b);
    return counted(settings, () => {
      const made = settings.Create(first, this.bodies[b]);
      this.system.AddConstraint(made);
      return made;
    });
  }

  step(size, count) {
    for (let i = 0; i < count; ++i) {
      this.held.forEach(({ force, torque }, body) => {
        vec(force, (v) => this.bodies[body].AddForce(v));
        vec(torque, (v) => this.bodies[body].AddTorque(v));
      });
      this.jolt.Step(size, 1);
    }
  }

  state() {
    return this.bodies.flatMap((body) => {
      if (body === null) return [0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0];
      // Each call may use the object again that the one before gave.
      const p = body.GetCenterOfMassPosition();
      const numbers = [p.GetX(), p.GetY(), p.GetZ()];
      const q = body.GetRotation();
      numbers.push(q.GetW(), q.GetX(), q.GetY(), q.GetZ());
      if (body.IsStatic()) return [...numbers, 0, 0, 0, 0, 0, 0];
      const v = body.GetLinearVelocity();
      numbers.push(v.GetX(), v.GetY(), v.GetZ());
      const w = body.GetAngularVelocity();
      numbers.push(w.GetX(), w.GetY(), w.GetZ());
      return numbers;
    });
  }

  hold(body, fx, fy, fz, tx, ty, tz) {
    this.held.set(body, { force: [fx, fy, fz], torque: [tx, ty, tz] });
  }

  kick(body, ...impulse) {
    vec(impulse, (v) => this.bodies[body].AddImpulse(v));
  }

  gravity(...gravity) {
    vec(gravity, (v) => this.system.SetGravity(v));
  }

  remove(body) {
    const id = this.bodies[body].GetID();
    this.interface.RemoveBody(id);
    this.interface.DestroyBody(id);
    this.bodies[body] = null;
    // What lay on it is not told.
    this.bodies.filter((other) => other !== null && !other.IsStatic())
      .forEach((other) => this.interface.ActivateBody(other.GetID()));
  }

  release(joint) {
    this.system.RemoveConstraint(this.joints[joint]);
    this.joints[joint] = null;
  }

  end() {
    this.joints?.filter((joint) => joint !== null).forEach((joint) => this.system.RemoveConstraint(joint));
    this.bodies?.filter((body) => body !== null).forEach((body) => {
      this.interface.RemoveBody(body.GetID());
      this.interface.DestroyBody(body.GetID());
    });
    Jolt.destroy(this.jolt);
    this.groups.Release();
  }
}

serve({
  name: "Jolt", version: versionOf("jolt-physics"),
  settings: "JoltPhysics.js: single precision, WebAssembly in Node; damping (0.05 by default) zero, gyroscopic force " +
    "on, speeds not held to 500 m/s and 47 rad/s, nobody sleeps, edges rounded by less than 5 cm where a shape is " +
    "smaller",
}, (scene) => new JoltWorld(scene));
