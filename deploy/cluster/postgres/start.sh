#!/usr/bin/env bash
# Starts one of several PostgreSQL servers, one of which can be written to, in the image postgres:15.
# The server called PRIMARY makes the database at its first start (init.sh); each other one copies it
# and follows. deploy/RUNBOOK.md says what to do when the primary is lost.
#
#   NODE_NAME   this server: its name for the others, and for synchronous_standby_names
#   PRIMARY     the one that can be written to
#   DOMAIN      what follows a server's name in its address, such as .database; default: nothing
#   NODES       all servers' names, with spaces between (init.sh)
#   REPLICATION_PASSWORD, DATABASE_PASSWORD, POSTGRES_PASSWORD   of the roles replication, dynmesh and
#               postgres, of letters and digits
set -euo pipefail
: "${NODE_NAME:?}" "${PRIMARY:?}" "${PGDATA:?}" "${REPLICATION_PASSWORD:?}"

# Each dynmeshd has up to 27 connections. Standbys need the primary's max_connections. A standby that
# was away longer than wal_keep_size lasts has to be copied anew.
settings=(-c max_connections=200 -c wal_keep_size=1GB)

if [[ $NODE_NAME == "$PRIMARY" ]]; then
  exec docker-entrypoint.sh postgres "${settings[@]}"
fi

umask 077
passwords=$(mktemp)
printf '*:*:*:replication:%s\n' "$REPLICATION_PASSWORD" >"$passwords"
# PRIMARY_ADDRESS: host and port in libpq's words; the test's.
primary="${PRIMARY_ADDRESS:-host=$PRIMARY${DOMAIN:-}} user=replication passfile=$passwords"

# A copy begins with backup_label. Without standby.signal it was not completed.
if [[ ! -e $PGDATA/standby.signal && ( ! -s $PGDATA/PG_VERSION || -e $PGDATA/backup_label ) ]]; then
  echo "copying the database of $PRIMARY" >&2
  mkdir -p "$PGDATA"
  until find "$PGDATA" -mindepth 1 -delete &&
    pg_basebackup -D "$PGDATA" -d "$primary" --checkpoint=fast; do
    sleep 2
  done
  touch "$PGDATA/standby.signal"
fi
if [[ ! -e $PGDATA/standby.signal ]]; then
  echo "$NODE_NAME has been the primary, which is now $PRIMARY: two must not be written to." \
    "Empty $PGDATA, and it becomes a standby" >&2
  exit 1
fi
# Not while it copies: only a server that follows counts for synchronous_standby_names.
primary+=" application_name=$NODE_NAME"
exec docker-entrypoint.sh postgres "${settings[@]}" -c "primary_conninfo=$primary"
