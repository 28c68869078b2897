# title: Statistic over two numbers
# caption: The statistic by colour over the two numbers that vary. There is one cell for each pair, with the
#   median over the other values, or one point for each case.
# alt: Colour map of a statistic over two numbers.
# format: png
name = ARG0[1:strlen(ARG0)-3]; width = 1000; height = 750
load 'common.gp'

set title head(statistic)
set xlabel x_label; set ylabel y_label; set cblabel value_label offset 1.5
eval x_axis; eval y_axis; eval value_axis
eval value_palette
set style fill solid noborder
if (cells) {
  set xrange [x_low:x_high]; set yrange [y_low:y_high]; set grid front
  plot name.'.dat' using 1:2:3:4:5:6:7 with boxxyerror linecolor palette notitle
} else {
  plot name.'.dat' using 1:2:7 with points pointtype 7 pointsize 1.2 linecolor palette notitle
}
