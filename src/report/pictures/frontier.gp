# title: Sets of terms that were tried
# caption: Each mark is a set of terms: above, its worst fitted statistic in tolerances; below, its worst
#   held-out statistic, judged on fresh rays or another grid, and the time of the fit. Sets below both dashed
#   lines pass; the square was taken.
# alt: Mismatch of fitted and held-out statistics over the number of terms.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1200; height = 900
load 'common.gp'

time_colour = ideal_colour
set multiplot layout 2,1 title head(fewest ? 'Fewest terms that pass' : 'Sets of terms that were tried') \
    font ',16'
set logscale xy; set xrange [low:high]; set lmargin 10; set rmargin 10
eval 'set xtics '.term_tics
set format y '%g'; set ylabel 'worst fitted statistic [tolerances]'; set yrange [*<0.5:2<*]
set key outside top center horizontal maxrows 2
plot 1 with lines linecolor rgb good_colour linewidth 1.5 dashtype 2 title 'tolerance', \
  'frontier_failed.dat' using 1:2 with points pointtype 2 pointsize 1.4 linecolor rgb fitted_colour \
    title 'fitted, does not pass', \
  'frontier_passed.dat' using 1:2 with points pointtype 7 pointsize 1.4 linecolor rgb target_colour \
    title 'passes', \
  'frontier_chosen.dat' using 1:2 with points pointtype 4 pointsize 3 linewidth 2 linecolor rgb 'black' \
    title 'taken'
unset key
set xlabel 'terms'; set ylabel 'worst held-out statistic [%]'
unset logscale y; set yrange [0:130*margin<*]
set y2label 'time of the set [s]' textcolor rgb time_colour
set logscale y2; set y2tics textcolor rgb time_colour; set format y2 '%g'
set label 1 'margin of the verdict' at graph 0.01, first 100*margin offset 0,0.6 textcolor rgb good_colour
plot 100*margin with lines linecolor rgb good_colour linewidth 1.5 dashtype 2 notitle, \
  'frontier_all.dat' using 1:4 axes x1y2 with linespoints pointtype 1 pointsize 0.7 linecolor rgb \
      time_colour \
    dashtype 3 linewidth 1 notitle, \
  'frontier_failed.dat' using 1:(100*$3) with points pointtype 2 pointsize 1.4 linecolor rgb fitted_colour, \
  'frontier_passed.dat' using 1:(100*$3) with points pointtype 7 pointsize 1.4 linecolor rgb target_colour, \
  'frontier_chosen.dat' using 1:(100*$3) with points pointtype 4 pointsize 3 linewidth 2 linecolor rgb 'black'
unset multiplot
