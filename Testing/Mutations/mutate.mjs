// SPDX-License-Identifier: BSD-3-Clause
// Do the tests notice a mistake? Changes one token of the product at a time, builds the tests of its library and runs
// them.
//   node mutate.mjs BUILD COUNT [SEED]     (./dev mutate)
// BUILD is the folder of a release build. Prints a line for each mutation: the test that has caught it, or that it
// survived. Mutations that do not compile are replaced by others. "(SIGTERM)" means that the tests did not end within a
// minute plus three times their usual time. Ends with "N caught, N survived". Restores the sources, also after Ctrl-C.
import { execFileSync, spawnSync } from 'node:child_process'
import { readFileSync, writeFileSync } from 'node:fs'

// The test programs for each folder, the fastest first. The first folder that matches is used.
const programs = [
  ['filters/core/', ['CoreTests', 'BuildTests']],
  ['filters/codec/', ['CodecTests', 'BuildTests']],
  ['viewer/session/', ['ViewerSessionTests']],
  ['filters/protocol/', ['ProtocolTests']],
  ['server/access/', ['AccessTests']],
  ['server/session/', ['SessionTests', 'HttpTests']],
  ['server/http/', ['HttpTests']]
]

// Typical small mistakes: a pattern, and its replacement.
const slips = [
  [/ < /g, ' <= '], [/ <= /g, ' < '], [/ > /g, ' >= '], [/ >= /g, ' > '],
  [/ == /g, ' != '], [/ != /g, ' == '], [/ && /g, ' || '], [/ \|\| /g, ' && '],
  [/ \+ 1\b/g, ''], [/ - 1\b/g, ''], [/ \+ /g, ' - '], [/ - /g, ' + '],
  [/\btrue\b/g, 'false'], [/\bfalse\b/g, 'true'], [/\bif \(!/g, 'if ('],
  [/\bstd::min\b/g, 'std::max'], [/\bstd::max\b/g, 'std::min'], [/\bcontinue;/g, 'break;'], [/\+= /g, '-= ']
]

// A generator of random numbers from 0 to 1 (mulberry32).
function numbers(seed) {
  return () => {
    seed = (seed + 0x6d2b79f5) | 0
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed)
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296
  }
}

// Every place that can be changed: file, position, pattern, replacement. Comments, includes, templates and assertions
// are left out.
function placesIn(file) {
  const places = []
  let offset = 0
  for (const line of readFileSync(file, 'utf8').split('\n')) {
    const code = line.replace(/\/\/.*/, '')
    if (!/^\s*(#|static_assert|template|class|struct|using)/.test(code)) {
      for (const [pattern, replacement] of slips) {
        for (const found of code.matchAll(pattern)) {
          places.push({ file, offset: offset + found.index, old: found[0], new: replacement })
        }
      }
    }
    offset += line.length + 1
  }
  return places
}

const [build, count, seed = '1'] = process.argv.slice(2)
if (!build || !(count > 0)) {
  console.error('usage: node mutate.mjs BUILD COUNT [SEED]')
  process.exit(2)
}
const any = numbers(Number(seed))
const files = execFileSync('git', ['ls-files', ...programs.map(([folder]) => folder)], { encoding: 'utf8' })
  .split('\n').filter(file => file.endsWith('.cxx') && !file.includes('/Testing/'))
const places = files.flatMap(placesIn)
const whole = new Map() // the original text of the file that is now changed
const restore = () => {
  for (const [file, text] of whole) writeFileSync(file, text)
  whole.clear()
}
for (const signal of ['SIGINT', 'SIGTERM']) {
  process.on(signal, () => { restore(); process.exit(130) })
}
// Handles signals, which the synchronous calls below block.
const heedSignals = () => new Promise(resolve => setImmediate(resolve))

function runTests(test, timeout) {
  return spawnSync(`${build}/bin/${test}`, ['--gtest_fail_fast', '--gtest_brief=1'],
    { encoding: 'utf8', timeout, maxBuffer: 1 << 28 })
}

// How long each program takes without changes; its tests must pass then.
const usual = new Map()
for (const test of new Set(programs.flatMap(([, tests]) => tests))) {
  if (spawnSync('cmake', ['--build', build, '--target', test]).status !== 0) {
    console.error(`${test} does not compile`)
    process.exit(1)
  }
  const begin = Date.now()
  if (runTests(test).status !== 0) {
    console.error(`${test} fails without a mutation`)
    process.exit(1)
  }
  usual.set(test, Date.now() - begin)
  await heedSignals()
}

let caught = 0, survived = 0
while (caught + survived < Number(count)) {
  const place = places[Math.floor(any() * places.length)]
  const text = readFileSync(place.file, 'utf8')
  whole.set(place.file, text)
  writeFileSync(place.file, text.slice(0, place.offset) + place.new + text.slice(place.offset + place.old.length))
  const tests = programs.find(([folder]) => place.file.startsWith(folder))[1]
  const line = text.slice(0, place.offset).split('\n').length
  const name = `${place.file}:${line}: '${place.old}' becomes '${place.new}'`
  let by = '', compiles = true
  for (const test of tests) {
    const built = spawnSync('cmake', ['--build', build, '--target', test], { encoding: 'utf8' })
    await heedSignals()
    compiles = built.status === 0
    if (!compiles) break
    const run = runTests(test, 60000 + 3 * usual.get(test))
    await heedSignals()
    if (run.status !== 0) {
      by = /\[  FAILED  \] (\S+)/.exec(run.stdout)?.[1] ?? `${test} (${run.signal ?? run.error?.code ?? run.status})`
      break
    }
  }
  if (compiles) {
    console.log(`${by ? 'caught by ' + by : 'SURVIVED'}: ${name}`)
    by ? ++caught : ++survived
  }
  restore()
}
spawnSync('cmake', ['--build', build, '--target', ...programs.flatMap(([, tests]) => tests)])
console.log(`${caught} caught, ${survived} survived`)
