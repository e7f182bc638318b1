// The service, at the address that the page came from.
import { createClient, type Client, type Interceptor } from '@connectrpc/connect';
import { createConnectTransport } from '@connectrpc/connect-web';
import { MeshService } from '../../gen/dynmesh/v1/mesh_service_pb.js';

export type Service = Client<typeof MeshService>;

const TOKEN = 'dynmesh.token';

/** The token of this tab, which its requests carry; null if there is none. */
export function token(): string | null {
  const value = sessionStorage.getItem(TOKEN);
  return value !== null && isToken(value) ? value : null;
}

/** False if the value cannot be a token; then nothing changes. */
export function setToken(value: string): boolean {
  if (!isToken(value)) return false;
  if (value === '') sessionStorage.removeItem(TOKEN);
  else sessionStorage.setItem(TOKEN, value);
  return true;
}

/** What a header of a request can have: fetch throws for characters of other scripts. */
export function isToken(value: string): boolean {
  return /^[\x21-\x7e]*$/.test(value);
}

const authorize: Interceptor = (next) => (request) => {
  const value = token();
  if (value !== null) request.header.set('Authorization', `Bearer ${value}`);
  return next(request);
};

export function connect(): Service {
  return createClient(
    MeshService,
    createConnectTransport({
      baseUrl: location.origin,
      useBinaryFormat: true,
      interceptors: [authorize],
    }),
  );
}
