import { App } from './app.js';
import { setHooks } from './hooks.js';

setHooks(new App());
