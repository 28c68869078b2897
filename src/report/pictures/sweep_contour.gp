# title: Lines of equal value
# caption: Lines on which the statistic has the value written on them, over the two numbers that vary. Dots
#   are the computed cases; the lines are interpolated between them.
# alt: Contour lines of a statistic over two numbers.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1000; height = 750
load 'common.gp'

set title head(value_label)
set xlabel x_label; set ylabel y_label
eval x_axis; eval y_axis
set xrange [x_low:x_high]; set yrange [y_low:y_high]
unset key
set table $lines
set contour base; unset surface
set cntrparam linear
eval 'set cntrparam levels discrete '.levels
splot name.'.dat' using 1:2:3 with lines notitle
unset table
set style textbox opaque noborder margins 0.5,0.3
plot name.'.dat' using 1:2 with points pointtype 7 pointsize 0.35 linecolor rgb '#999999', \
  $lines using 1:2 with lines linecolor rgb target_colour linewidth 2 dashtype 1, \
  for [i=1:labels] name.'_labels.dat' using 1:2:3 with labels font ',13' textcolor rgb 'black' boxed
