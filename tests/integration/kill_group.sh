# Sourced by kill.sh: one of two processes of a training group is killed. The other ends by itself, with an error, within
# three times the group's timeout; the group is started again and ends with the checkpoints of a group that nobody disturbed.
group_timeout_s=20
# LibTorch waits longer and longer between its attempts to connect to a rank 0 that is not there.
most_s=$((3 * group_timeout_s + 10))

# start_group FOLDER: two ranks in the background, `ranks` their processes.
start_group() {
  training_command "$1"
  start_ranks group "${command[@]}" --group-timeout $group_timeout_s
}

# end_of PROCESS: its exit status into `status`; an error when it runs on for longer than that.
end_of() {
  local waited=0
  status=0
  while kill -0 "$1" 2>/dev/null && ((waited++ < 10 * most_s)); do sleep 0.1; done
  ! kill -KILL "$1" 2>/dev/null || fail "a process of a group runs on after the other was killed"
  wait "$1" 2>/dev/null || status=$?
}

whole_group() {
  start_group "$1"
  local rank
  for rank in 0 1; do
    end_of "${ranks[rank]}"
    ((status == 0)) || { cat "$own"/group.?.err >&2; fail "a group ends with $status"; }
  done
}

killed_groups() {
  local wanted=$1 done=0 runs=0 late=0 start wall longest=0 took folder moment victim
  start=$(now_ms)
  whole_group "$own/group_whole"
  wall=$(($(now_ms) - start))
  while ((done < wanted)); do
    folder="$own/group_$((++runs))" victim=$((RANDOM % 2)) moment=$((wall * (done * 32768 + RANDOM) / (wanted * 32768)))
    start_group "$folder"
    sleep "$(seconds "$moment")"
    kill -KILL "${ranks[victim]}" 2>/dev/null || true
    status=0
    wait "${ranks[victim]}" 2>/dev/null || status=$?
    local killed=$status
    start=$(now_ms)
    end_of "${ranks[1 - victim]}"
    took=$(($(now_ms) - start))
    local other=$status
    [[ ! -d "$folder" ]] || python3 "$files" whole "$folder"
    if ((killed == 137)); then
      # A process that has nothing left to exchange may end well.
      ((other == 2)) && (($(grep -c '^diffsac_train: ' "$own/group.$((1 - victim)).err") == 1)) || ((other == 0)) ||
        { cat "$own"/group.?.err >&2; fail "the other process ends with $other"; }
      done=$((done + 1)) longest=$((took > longest ? took : longest))
    else
      ((++late <= wanted + 5)) || fail "the groups end before they can be killed"
    fi
    whole_group "$folder"
    python3 "$files" same "$own/group_whole" "$folder" || fail "group: seed $seed, run $runs ends otherwise"
    rm -rf "$folder"
  done
  echo "group: $done kills in $runs runs of $(seconds "$wall") s, $late came too late; the other process ended within" \
    "$(seconds "$longest") s"
}
