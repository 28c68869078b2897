# title: Statistic over what varies
# caption: The statistic over the first number that varies. There is one line for each value of the other
#   numbers, or their median with bands that hold 50 % and 90 % of the realisations.
# alt: Curves of a statistic over the number that varies.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1000; height = 700
load 'common.gp'

set title head(statistic)
set xlabel x_label; set ylabel y_label
eval x_axis; eval y_axis
if (lines == 0) {
  plot name.'.dat' using 1:2 with points pointtype 7 pointsize 0.5 linecolor rgb colour[1] title 'cases'
} else {
  plot for [i=1:bands] name.'.dat' index i-1 using 1:3:6 with filledcurves fillcolor rgb colour[i] \
      fillstyle transparent solid 0.15 noborder title (lines == 1 ? '5 to 95 %' : ''), \
    for [i=1:bands] '' index i-1 using 1:4:5 with filledcurves fillcolor rgb colour[i] \
      fillstyle transparent solid 0.3 noborder title (lines == 1 ? '25 to 75 %' : ''), \
    for [i=1:lines] '' index i-1 using 1:2 with linespoints linecolor rgb colour[i] linewidth 2.5 dashtype 1 \
      pointtype 7 pointsize mark title label[i]
}
