// What a peer is, for Node: see protocol.py.
import fs from "node:fs";
import { createRequire } from "node:module";

// s of processor time that one request may take: who needs more is too slow to be measured.
const TIME_MAX = 20;

// Engines greet on the console, and the standard output is for answers alone.
console.log = console.error;

// What an engine cannot do; the message names it.
export class Refused extends Error {}

// A scene in the hands of an engine. What a subclass leaves out is refused.
export class World {
  hold() {
    throw new Refused("forces that go on");
  }
  kick() {
    throw new Refused("impulses");
  }
  gravity() {
    throw new Refused("gravity that changes");
  }
  remove() {
    throw new Refused("bodies that are removed");
  }
  release() {
    throw new Refused("joints that are removed");
  }
  // Gives memory back that nobody else does.
  end() {}
}

export const rotate = ([w, x, y, z], v) => {
  const t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])];
  return [v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2],
          v[2] + w * t[2] + x * t[1] - y * t[0]];
};

// Quaternions, w first: first b, then a.
export const multiply = ([p, q, r, s], [w, x, y, z]) => [
  p * w - q * x - r * y - s * z, p * x + q * w + r * z - s * y,
  p * y - q * z + r * w + s * x, p * z + q * y - r * x + s * w,
];

// Of a package beside this file.
export const versionOf = (name) => createRequire(import.meta.url)(`./node_modules/${name}/package.json`).version;

function processorTime() {
  const { user, system } = process.cpuUsage();
  return 1e-6 * (user + system);
}

function run(world, size, count) {
  const begin = processorTime();
  let spent = 0;
  for (let done = 0, together = 8; done < count;) {
    if (spent > TIME_MAX) throw new Refused(`slow: ${count} steps take more than ${TIME_MAX} s`);
    const many = Math.min(together, count - done);
    world.step(size, many);
    done += many;
    spent = processorTime() - begin;
    // As few looks at the clock as the limit needs.
    if (spent < 0.01) together *= 2;
  }
  return spent;
}

function* lines() {
  const buffer = Buffer.alloc(65536);
  let parts = [];
  for (let count; (count = fs.readSync(0, buffer)) > 0;) {
    let begin = 0;
    for (let end; (end = buffer.subarray(0, count).indexOf(10, begin)) >= 0; begin = end + 1) {
      parts.push(Buffer.from(buffer.subarray(begin, end)));
      yield Buffer.concat(parts).toString();
      parts = [];
    }
    parts.push(Buffer.from(buffer.subarray(begin, count)));
  }
}

// Obeys until the input ends. `start` makes a world of a scene, or throws Refused.
export function serve(about, start) {
  let world = null;
  let failure = "no scene was started";
  const verbs = {
    start: (scene) => {
      world?.end();
      world = null;
      world = start(scene);
      return "ok";
    },
    time: (size, count) => `ok ${run(world, size, count)}`,
    state: () => `ok ${world.state().join(" ")}`,
    step: (size, count) => void run(world, size, count),
  };
  const answer = (verb, parameters) => {
    if (verb === "about") return `ok ${JSON.stringify(about)}`;
    const isAnswered = ["start", "time", "state"].includes(verb);
    if (world === null && verb !== "start") return isAnswered ? `no ${failure}` : undefined;
    try {
      return verb in verbs ? verbs[verb](...parameters) : void world[verb](...parameters);
    } catch (error) {
      world?.end();
      world = null;
      failure = String(error.message ?? error).replace(/\s+/g, " ");
      return isAnswered ? `no ${failure}` : undefined;
    }
  };
  for (const line of lines()) {
    const [verb, ...parameters] = JSON.parse(line);
    const said = answer(verb, parameters);
    if (said !== undefined) fs.writeSync(1, `${said}\n`);
  }
}
