# Every row gives the same on 1 and on 8 threads, to the bit: models, inliers, probabilities, errors.
# Of all tables, the real data in DATA and under runs/ included, where it and the networks are there:
# tests/integration/threads.sh BUILD SOURCE FOLDER DATA
source "$(dirname "$0")/common.sh"

# The conditions of generated data and of the benchmark on very many points, whose rows are those of all tasks.
tables=(configs/tables/line.yaml configs/tables/plane.yaml benchmarks/large/fundamental.yaml benchmarks/large/essential.yaml
  benchmarks/large/homography.yaml)
limit=2
data=()
if [[ -n "${4:-}" ]]; then
  tables=(configs/tables/*.yaml benchmarks/large/*.yaml) data=(--data "$4") limit=3
fi

differ() {
  python3 - "$1" "$2" <<'END'
import csv, sys
def rows(folder):
    with open(folder + "/problems.csv") as file:
        return [{k: v for k, v in row.items() if not k.startswith("ms_")} for row in csv.DictReader(file)]
one, eight = map(rows, sys.argv[1:])
assert one and len(one) == len(eight), "another number of rows"
for a, b in zip(one, eight):
    assert a == b, f"{a['method']}, {a['id']}: " + ", ".join(f"{k} {a[k]} / {b[k]}" for k in a if a[k] != b[k])
print(len({row["method"] for row in one}), "rows,", len(one), "estimates")
END
}

for table in "${tables[@]}"; do
  name=$(basename "$table" .yaml)
  points=()
  if [[ "$table" == benchmarks/* ]]; then points=(--set data.num_points=400 --set problems=$limit); fi
  run() {
    evaluate --config "$table" --limit "$limit" --device cpu --threads "$1" "${data[@]}" "${points[@]}" \
      --set estimates=true --output "$own/$name-$1" >"$own/out" 2>"$own/err"
  }
  if ! run 1; then
    [[ -n "${4:-}" ]] || { cat "$own/err" >&2; fail "$name"; }
    echo "$name left out: $(grep '^diffsac_eval' "$own/err")"
    continue
  fi
  run 8 || fail "$name with 8 threads: $(cat "$own/err")"
  if [[ ! -e "$own/$name-1/estimates.h5" && -n "${4:-}" ]]; then
    echo "$name left out: no row has its data and network"
    continue
  fi
  cmp "$own/$name-1/estimates.h5" "$own/$name-8/estimates.h5" || fail "$name: threads change estimates"
  echo "$name: $(differ "$own/$name-1" "$own/$name-8")" || fail "$name: threads change results"
done
