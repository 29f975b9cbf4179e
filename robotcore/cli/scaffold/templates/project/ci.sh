#!/bin/sh
# The checks of this project, on your computer and in CI. `sh ci.sh` runs all of them, `sh ci.sh sweep` runs one.
# They need what `sh ci.sh install` installs, in an environment such as one of `python -m venv`.
# The results are in build/: JUnit files in build/junit, the report of the sweep, and the badge.
set -eu
CDPATH= cd -- "$(dirname -- "$0")"
mkdir -p build/junit

part=${1:-all}
case $part in
install)
    python -m pip install -r requirements.txt
    ;;
tests)
    python -m pytest --junit-xml=build/junit/tests.xml
    ;;
sweep) # The gate: the app must find the ball in these rooms, and touch nothing.
    robotcore sweep search.py --robot my_robot.toml --world room.toml --seeds "${SEEDS:-1-50}" \
        --require "verified>=0.95" --require "contacts<=0" \
        --report build/report --junit build/junit/sweep.xml --badge build/badge.svg
    ;;
replay) # A new recording: the app must decide by its samples alone. The kept recordings: it must decide as before.
    rm -f build/new.mcap build/junit/replay-*.xml # also the test cases of deleted recordings
    robotcore run search.py --robot my_robot.toml --world room.toml --seed 7 --record build/new.mcap ||
        echo "This run has failed. Its decisions are replayed nevertheless." >&2
    [ -e build/new.mcap ] || { echo "The run has recorded nothing, so there is nothing to replay" >&2 && exit 1; }
    differing=
    for recording in build/new.mcap recordings/*.mcap; do
        [ -e "$recording" ] || [ -L "$recording" ] || continue # if no file matches, the shell leaves the pattern as it is
        case $recording in build/*) name=new ;; *) name=kept-$(basename "$recording" .mcap) ;; esac
        robotcore replay "$recording" --app search.py --require-equal --junit "build/junit/replay-$name.xml" ||
            differing="$differing $recording"
    done
    [ -z "$differing" ] || { echo "These replays have failed:$differing" >&2 && exit 1; }
    ;;
all)
    failed=
    for each in tests sweep replay; do
        echo "== $each"
        sh ci.sh "$each" || failed="$failed $each"
    done
    [ -z "$failed" ] || { printf 'These checks have failed:%s\n' "$failed" >&2 && exit 1; }
    ;;
*)
    printf 'ci.sh: unknown check %s. Use install, tests, sweep or replay, or no argument for all\n' "$part" >&2
    exit 2
    ;;
esac
