// The service, at the address that the page came from.
import { createClient, type Client, type Interceptor } from '@connectrpc/connect';
import { createConnectTransport } from '@connectrpc/connect-web';
import { MeshService } from '../../gen/dynmesh/v1/mesh_service_pb.js';

export type Service = Client<typeof MeshService>;

const TOKEN = 'dynmesh.token';

/** The token of this tab, which its requests carry; null if there is none. */
export function token(): string | null {
  return sessionStorage.getItem(TOKEN);
}

export function setToken(value: string): void {
  if (value === '') sessionStorage.removeItem(TOKEN);
  else sessionStorage.setItem(TOKEN, value);
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
