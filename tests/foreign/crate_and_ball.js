// What the README's grpcurl lines do, from JavaScript: the server describes itself by reflection.
'use strict';

const assert = require('node:assert');
const grpc = require('@grpc/grpc-js');
const {GrpcReflection} = require('grpc-js-reflection-client');

const address = process.argv[2];

async function service(name) {
  const reflection = new GrpcReflection(address, grpc.credentials.createInsecure());
  const descriptor = await reflection.getDescriptorBySymbol(name);
  const root = descriptor.getPackageObject({keepCase: true, longs: String, enums: String});
  const Stub = name.split('.').reduce((object, part) => object[part], root);
  const stub = new Stub(address, grpc.credentials.createInsecure());
  const call = (method, request) => new Promise((resolve, reject) => {
    const deadline = new Date(Date.now() + 30000);
    stub[method](request, {deadline}, (error, reply) => (error ? reject(error) : resolve(reply)));
  });
  return {stub, call};
}

function body(shape, position) {
  return {pose: {position}, rigid_body: {geometries: [{shape}]}};
}

async function main() {
  const worlds = await service('genphys.v1.WorldService');
  const simulation = await service('genphys.v1.SimulationService');

  const world = (await worlds.call('CreateWorld', {})).world.name;
  const crate = await simulation.call('CreateEntity', {world, entity: body({box: {}}, {z: 0.5})});
  const ball = await simulation.call('CreateEntity', {world, entity: body({sphere: {}}, {x: 0.7, z: 5})});
  await simulation.call('ApplyForce', {world, force: {entity_id: ball.entity.id, force: {x: 100}, steps: 60}});

  const events = simulation.stub.WatchEvents({world, after_sequence: 0});
  const met = new Promise((resolve, reject) => {
    let next = 1;
    events.on('error', reject);
    events.on('data', (message) => {
      for (const event of (message.batch ? message.batch.events : [])) {
        assert.strictEqual(Number(event.sequence), next++);
        const began = event.contact_began;
        if (began && began.entity_b === ball.entity.id) resolve(Number(event.step));
      }
    });
  });
  const reply = await simulation.call('Step', {world, steps: 120, frame: {poses: true}});
  assert.strictEqual(Number(reply.stamp.step), 120);
  // Three entities of three float64 each: the floor, the crate and the ball.
  assert.strictEqual(reply.frame.positions.length, 3 * 3 * 8);
  const step = await met;
  assert.ok(step > 40 && step < 120, `the ball met something at step ${step}`);
  events.removeAllListeners('error');
  events.on('error', () => {});
  events.cancel();

  const refusal = await simulation.call('CreateEntity', {world, entity: body({sphere: {radius: NaN}}, {})})
    .then(() => null, (error) => error);
  assert.strictEqual(refusal.code, grpc.status.INVALID_ARGUMENT);
  assert.strictEqual(crate.entity.id, '2');
  console.log('ok');
}

main().then(() => process.exit(0), (error) => {
  console.error(error);
  process.exit(1);
});
