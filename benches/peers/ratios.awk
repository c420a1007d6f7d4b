# Ratios from rows lib,scene,config,threads,metric,value: of times the least counts, of speeds the largest.
# A file that is no such table may come first: the stored single-ray speeds in Markdown, four a cell, a column a scene.
# A ratio above one means that Rayframe is faster.
function better(metric, a, b) { return metric ~ /_ms/ ? a < b : a > b }
function value(library, scene, config, threads, metric) { return best[library, scene, config, threads, metric] + 0 }
function over(a, b) { return a > 0 && b > 0 ? sprintf("%.2f", a / b) : "-" }
# The best of a library over configurations and kinds of a metric, where kinds are its endings; `by` says whose it is.
function best_of(library, scene, threads, metric, kinds, only,    c, k, n, parts, found, v) {
  found = 0; by = "-"; n = split(kinds, parts, " ")
  for (c = 1; c <= configs[library]; c++) if (only == "" || config_of[library, c] == only)
    for (k = 1; k <= n; k++) {
      v = value(library, scene, config_of[library, c], threads, metric parts[k])
      if (v > 0 && (!found || better(metric, v, found))) { found = v; by = config_of[library, c] " " substr(parts[k], 2) }
    }
  return found
}
function mean(name, ratio, scene) { if (ratio != "-" && scene != "pipes") { sums[name] += log(ratio); counts[name]++; if (!(name in least) || ratio < least[name]) least[name] = ratio } }
function show_mean(name) { if (counts[name]) printf "  %s: geometric mean %.2f, least %.2f, over %d\n", name, exp(sums[name] / counts[name]), least[name], counts[name] }

# Stored speeds
/^### /   { single = /Single-ray/ }
single && /^\| tracer/ { columns = split($0, head, /[ ]*\|[ ]*/) }
single && /^\| (tinybvh|obvhs-native)/ {
  split($0, cell, /[ ]*\|[ ]*/); split(cell[2], name, " ")
  for (i = 3; i < columns; i++) { split(cell[i], speed, " / ")
    for (s = 1; s <= 4; s++) if (speed[s] + 0 > stored[name[1], head[i], s] + 0) stored[name[1], head[i], s] = speed[s] + 0 }
}
# Rows
/^[a-z0-9-]+,[^,]*,[^,]*,[0-9]+,[^,]*,[0-9.e+-]+$/ {
  split($0, f, ",")
  if (!((f[1], f[3]) in seen)) { seen[f[1], f[3]] = 1; config_of[f[1], ++configs[f[1]]] = f[3] }
  if (!(f[2] in known)) { known[f[2]] = 1; scenes[++scene_count] = f[2] }
  key = f[1] SUBSEP f[2] SUBSEP f[3] SUBSEP f[4] SUBSEP f[5]
  if (!(key in best) || better(f[5], f[6] + 0, best[key])) best[key] = f[6] + 0
}

END {
  split("primary shadow reflect diffuse", sets, " ")
  theirs = configs["obvhs-native"] ? "obvhs-native" : "obvhs"

  print "Whole frame: rebuild and the three coherent sets, ms"
  printf "%-8s %3s %9s %-22s %9s %-8s %6s %9s %-20s %6s\n", "scene", "thr", "Embree", "by", "auto", "by", "ratio", "best", "by", "ratio"
  for (t = 1; t <= 2; t++) for (i = 1; i <= scene_count; i++) { s = scenes[i]
    e = best_of("embree3", s, t, "frame_ms", ":single :packet16", ""); e_by = by
    a = best_of("rayframe", s, t, "frame_ms", ":single :packet", "auto"); a_by = by; sub(/^auto /, "", a_by)
    b = best_of("rayframe", s, t, "frame_ms", ":single :packet", ""); b_by = by
    printf "%-8s %3d %9.1f %-22s %9.1f %-8s %6s %9.1f %-20s %6s\n", s, t, e, e_by, a, a_by, over(e, a), b, b_by, over(e, b)
    mean("Embree / auto, threads " t, over(e, a), s); mean("Embree / best, threads " t, over(e, b), s) }
  for (t = 1; t <= 2; t++) { show_mean("Embree / auto, threads " t); show_mean("Embree / best, threads " t) }

  print "\nSingle rays, millions a second, 1 thread; tinybvh by its stored ratio to " theirs "'s best"
  printf "%-8s %-8s %9s %9s %-20s %6s %9s\n", "scene", "set", "auto", theirs, "by", "ratio", "/tinybvh"
  for (i = 1; i <= scene_count; i++) for (k = 1; k <= 4; k++) { s = scenes[i]
    a = value("rayframe", s, "auto", 1, "mrays:" sets[k] ":single")
    o = best_of(theirs, s, 1, "mrays:" sets[k], ":single", ""); o_by = by
    tiny = stored["tinybvh", s, k]; base = stored["obvhs-native", s, k]
    r = tiny > 0 && base > 0 ? over(a, o * tiny / base) : "-"
    printf "%-8s %-8s %9.2f %9.2f %-20s %6s %9s\n", s, sets[k], a, o, o_by, over(a, o), r
    mean("auto / " theirs, over(a, o), s); mean("auto / tinybvh", r, s) }
  show_mean("auto / " theirs); show_mean("auto / tinybvh")

  print "\nBatches, millions of rays a second, 1 thread, against Embree's packets of 16"
  printf "%-8s %-8s %9s %9s %-20s %6s\n", "scene", "set", "auto", "Embree", "by", "ratio"
  for (i = 1; i <= scene_count; i++) for (k = 1; k <= 4; k++) { s = scenes[i]
    a = value("rayframe", s, "auto", 1, "mrays:" sets[k] ":packet")
    e = best_of("embree3", s, 1, "mrays:" sets[k], ":packet16", "")
    printf "%-8s %-8s %9.2f %9.2f %-20s %6s\n", s, sets[k], a, e, by, over(a, e) }

  print "\nPlain LBVH with buffers kept, ms, against Embree's recommit at low quality"
  printf "%-8s %9s %9s %6s %9s %9s %6s %8s\n", "scene", "Embree 1", "ours 1", "ratio", "Embree 2", "ours 2", "ratio", "speedup"
  for (i = 1; i <= scene_count; i++) { s = scenes[i]
    for (t = 1; t <= 2; t++) { e_ms[t] = value("embree3", s, "low-morton", t, "rebuild_ms"); o_ms[t] = value("rayframe", s, "lbvh", t, "rebuild_ms") }
    printf "%-8s %9.2f %9.2f %6s %9.2f %9.2f %6s %8s\n", s, e_ms[1], o_ms[1], over(e_ms[1], o_ms[1]), e_ms[2], o_ms[2], over(e_ms[2], o_ms[2]), over(o_ms[1], o_ms[2]) }

  print "\nSplitting plain LBVH: single primary rays with splits over without, references a triangle, wide nodes a ray"
  for (i = 1; i <= scene_count; i++) { s = scenes[i]
    printf "%-8s %6s times faster, %6.3f references, nodes %.2f -> %.2f\n", s,
      over(value("rayframe", s, "lbvh-split", 1, "mrays:primary:single"), value("rayframe", s, "lbvh", 1, "mrays:primary:single")),
      value("rayframe", s, "lbvh-split", 1, "references"),
      value("rayframe", s, "lbvh", 1, "nodes:primary:single"), value("rayframe", s, "lbvh-split", 1, "nodes:primary:single") }

  print "\nThe renderer's queries over the benchmark's batches of as many rays, ms (at most 1.3 wanted)"
  for (t = 1; t <= 2; t++) for (i = 1; i <= scene_count; i++) { s = scenes[i]
    r = value("rayframe", s, "auto", t, "trace_ms:render"); b = value("rayframe", s, "auto", t, "trace_ms:rays")
    printf "%-8s %3d %9.1f %9.1f %6s\n", s, t, r, b, over(r, b) }
}
