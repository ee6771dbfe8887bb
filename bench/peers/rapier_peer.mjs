// Rapier as a peer, as WebAssembly.
import RAPIER from "@dimforge/rapier3d-compat";

import { Refused, World, multiply, serve, versionOf } from "./protocol.mjs";

const xyz = ([x, y, z]) => ({ x, y, z });
const turn = ([w, x, y, z]) => ({ w, x, y, z });
// Its capsules and cylinders are along y.
const FROM_Y = [Math.SQRT1_2, Math.SQRT1_2, 0, 0];
// What moves in a joint does so along or about x.
const FROM_X = [Math.SQRT1_2, 0, -Math.SQRT1_2, 0];

function colliderOf(shape) {
  const desc = RAPIER.ColliderDesc;
  switch (shape.kind) {
    case "sphere": return desc.ball(shape.radius);
    case "box": return desc.cuboid(...shape.half_extents);
    case "capsule": return desc.capsule(shape.half_length, shape.radius).setRotation(turn(FROM_Y));
    case "cylinder": return desc.cylinder(shape.half_length, shape.radius).setRotation(turn(FROM_Y));
    case "plane": {
      const place = shape.normal.map((n) => n * shape.offset);
      return new desc(new RAPIER.HalfSpace(xyz(shape.normal))).setTranslation(...place);
    }
    case "hull": return desc.convexHull(new Float32Array(shape.points.flat()));
    case "mesh": return desc.trimesh(new Float32Array(shape.points.flat()), new Uint32Array(shape.indices));
    default: throw new Refused(`shapes of the kind ${shape.kind}`);
  }
}

class RapierWorld extends World {
  constructor(scene) {
    super();
    this.scene = scene;
    this.world = new RAPIER.World(xyz(scene.gravity));
    // What is joined to the world is joined to it.
    this.origin = this.world.createRigidBody(RAPIER.RigidBodyDesc.fixed());
    if (scene.ground) this.giveShape({ kind: "plane", normal: [0, 0, 1], offset: 0 }, this.origin);
    this.bodies = scene.bodies.map((body) => this.giveBody(body));
    this.joints = scene.joints.map((joint) => this.giveJoint(joint));
  }

  giveShape(shape, body) {
    const { friction, restitution } = this.scene;
    this.world.createCollider(colliderOf(shape).setDensity(0).setFriction(friction).setRestitution(restitution), body);
  }

  giveBody(body) {
    const desc = body.mass === null ? RAPIER.RigidBodyDesc.fixed() : RAPIER.RigidBodyDesc.dynamic();
    desc.setTranslation(...body.position).setRotation(turn(body.orientation)).setCanSleep(false);
    if (body.mass !== null) {
      const [xx, yy, zz, ...aside] = body.tensor;
      if (Math.max(...aside.map(Math.abs)) > 1e-12 * Math.max(xx, yy, zz)) {
        throw new Refused("tensors whose axes are not the body's");
      }
      desc.setLinvel(...body.velocity).setAngvel(xyz(body.spin));
      desc.setAdditionalMassProperties(body.mass, xyz([0, 0, 0]), xyz([xx, yy, zz]), turn([1, 0, 0, 0]));
    }
    const made = this.world.createRigidBody(desc);
    this.giveShape(body.shape, made);
    return made;
  }

  giveJoint({ kind, a, b, in_a: inA, in_b: inB }) {
    const [p, q, axis] = [xyz(inA.position), xyz(inB.position), { x: 1, y: 0, z: 0 }];
    const data = kind === "ball" ? RAPIER.JointData.spherical(p, q)
      : kind === "hinge" ? RAPIER.JointData.revolute(p, q, axis) : RAPIER.JointData.prismatic(p, q, axis);
    const joint = this.world.createImpulseJoint(data, a === null ? this.origin : this.bodies[a], this.bodies[b], true);
    joint.setFrameX1(turn(multiply(inA.orientation, FROM_X)));
    joint.setFrameX2(turn(multiply(inB.orientation, FROM_X)));
    joint.setContactsEnabled(false);
    return joint;
  }

  step(size, count) {
    this.world.timestep = size;
    for (let i = 0; i < count; ++i) this.world.step();
  }

  state() {
    return this.bodies.flatMap((body) => {
      if (body === null) return [0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0];
      const [p, q, v, w] = [body.translation(), body.rotation(), body.linvel(), body.angvel()];
      return [p.x, p.y, p.z, q.w, q.x, q.y, q.z, v.x, v.y, v.z, w.x, w.y, w.z];
    });
  }

  // They stay until they are taken away.
  hold(body, fx, fy, fz, tx, ty, tz) {
    this.bodies[body].resetForces(true);
    this.bodies[body].resetTorques(true);
    this.bodies[body].addForce(xyz([fx, fy, fz]), true);
    this.bodies[body].addTorque(xyz([tx, ty, tz]), true);
  }

  kick(body, ...impulse) {
    this.bodies[body].applyImpulse(xyz(impulse), true);
  }

  gravity(...gravity) {
    this.world.gravity = xyz(gravity);
  }

  remove(body) {
    this.world.removeRigidBody(this.bodies[body]);
    this.bodies[body] = null;
  }

  release(joint) {
    this.world.removeImpulseJoint(this.joints[joint], true);
  }

  end() {
    this.world.free();
  }
}

await RAPIER.init();
serve({
  name: "Rapier", version: versionOf("@dimforge/rapier3d-compat"),
  settings: "single precision, WebAssembly in Node; all defaults, nobody sleeps",
}, (scene) => new RapierWorld(scene));
