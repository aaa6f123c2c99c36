// Makes the two scripts that pages of quern carry: plots.js (plots and tables) and charge.js (the charge in 3-D), each whole in itself, with
// the licences of what is in it at its head. `node build.js FOLDER`; the packages stand in FOLDER/node_modules.
import { readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const folder = resolve(process.argv[2] ?? here);
const { build } = createRequire(join(folder, 'package.json'))('esbuild');

const packageOf = (input) => {
  const parts = input.split('node_modules/').pop().split('/');
  return parts[0].startsWith('@') ? parts.slice(0, 2).join('/') : parts[0];
};

const licenceOf = (name) => {
  const home = join(folder, 'node_modules', name);
  const { version, license } = JSON.parse(readFileSync(join(home, 'package.json')));
  const file = readdirSync(home).find((f) => /^licen[sc]e/i.test(f));
  const text = file ? readFileSync(join(home, file), 'utf8').trim() : `Licence: ${license}`;
  return `${name} ${version}\n\n${text}`;
};

for (const name of ['plots', 'charge']) {
  const result = await build({
    absWorkingDir: here,
    entryPoints: [`src/${name}.js`],
    nodePaths: [join(folder, 'node_modules')],
    bundle: true,
    minify: true,
    format: 'iife',
    target: 'es2020',
    charset: 'utf8',
    legalComments: 'none', // the whole texts stand at the head
    loader: { '.css': 'text' },
    write: false,
    metafile: true,
    logLevel: 'warning',
  });
  const inputs = Object.values(result.metafile.outputs)[0].inputs;
  const packages = new Set(Object.keys(inputs).filter((input) => input.includes('node_modules/')).map(packageOf));
  const notice = [...packages].sort().map(licenceOf).join('\n\n----\n\n').replaceAll('*/', '* /');
  // Within a page nothing may look like the end of a script.
  const text = `/*! This script is a part of quern, GPL-3.0-or-later. In it are:\n\n${notice}\n*/\n${result.outputFiles[0].text}`.replace(/<\/(script)/gi, '<\\/$1').replaceAll('<!--', '<\\!--');
  writeFileSync(join(folder, `${name}.js`), text);
}
