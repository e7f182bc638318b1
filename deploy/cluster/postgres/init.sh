#!/usr/bin/env bash
# Run by the image postgres:15 at the first start of the primary, while it accepts local connections
# only: roles, the database, and which standbys confirm a commit.
set -euo pipefail
: "${NODES:?}" "${DATABASE_PASSWORD:?}" "${REPLICATION_PASSWORD:?}"

# One other server, whichever, has an edit on its disk before the edit is answered. All are listed,
# so that the list is right after another one became the primary. Set here, not on the command line:
# the statements above would wait for a standby.
read -ra nodes <<<"$NODES"
names=$(printf ', "%s"' "${nodes[@]}")
psql -v ON_ERROR_STOP=1 -U postgres \
  -v database="$DATABASE_PASSWORD" -v replication="$REPLICATION_PASSWORD" <<SQL
CREATE ROLE dynmesh LOGIN PASSWORD :'database';
CREATE DATABASE dynmesh OWNER dynmesh;
CREATE ROLE replication LOGIN REPLICATION PASSWORD :'replication';
ALTER SYSTEM SET synchronous_standby_names = 'ANY 1 (${names#, })';
SQL
echo "host replication replication all scram-sha-256" >>"$PGDATA/pg_hba.conf"
