# gnuplot -e "csv='growth.csv'; png='growth.png'" benchmarks/growth.gp: what diffsac_guide_benchmark --csv growth.csv wrote.
set terminal pngcairo size 760,440 font "sans,11"
set output png
set datafile separator ","
set logscale xy
set xrange [400:120000]
set rmargin 5
set xlabel "matches"
set ylabel "milliseconds, one thread"
set key top left
set grid
of(row) = sprintf("< grep ',%s,' %s", row, csv)
plot of("shipped") using 1:3 with linespoints lw 2 title "shipped", \
     of("prosac_marginalised") using 1:3 with linespoints lw 2 title "prosac\\_scales (no network)", \
     of("usac") using 1:3 with linespoints lw 2 title "OpenCV USAC\\_ACCURATE 1000", \
     x / 60.0 dashtype 2 lc rgb "gray50" title "in proportion to N"
