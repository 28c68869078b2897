# title: Error against time
# caption: Each mark is a setting with its error and its time (bars: quartiles). On the grey stairs no
#   measured setting is better. A large circle is the study's setting, a red diamond the cheapest one within
#   the tolerance.
# alt: Error over time of every setting, by method.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1200; height = 850
load 'common.gp'

set lmargin at screen frame[1]; set rmargin at screen frame[2]
set bmargin at screen frame[3]; set tmargin at screen frame[4]
set label head(what) at screen 0.53, screen 0.972 center
set key at screen 0.53, screen 0.95 center top horizontal font ',12' samplen 2
set xlabel x_label; set ylabel y_label offset 0.5,0
eval x_axis; eval y_axis
if (tolerance > 0) {
  set arrow from graph 0, first tolerance to graph 1, first tolerance nohead linecolor rgb '#AA0000' \
      dashtype 2
  if (on_right) { set label tolerance_text at graph 0.992, first tolerance right offset 0,0.6 \
    textcolor rgb '#AA0000' font ',11' }
  else { set label tolerance_text at graph 0.008, first tolerance left offset 0,0.6 \
    textcolor rgb '#AA0000' font ',11' }
}
mark(m) = int(word('7 5 9 11 13 7 5', (m-1)%7+1))
plot for [i=1:frontier] name.'_frontier.dat' using 1:4 with steps linecolor rgb '#d4d4d4' linewidth 5 \
    dashtype 1 \
    title 'best of those measured', \
  for [m=1:methods] name.'_methods.dat' index m-1 using 1:4:2:3 with xerrorbars pointtype mark(m) \
      pointsize 0.9 \
    linewidth 1.2 dashtype 1 linecolor rgb colour[(m-1)%7+1] title method[m], \
  for [i=1:today] name.'_today.dat' using 1:4 with points pointtype 6 pointsize 1.5 linewidth 2 \
    linecolor rgb '#000000' notitle, \
  for [i=1:today] NaN with points pointtype 6 pointsize 1 linewidth 2 \
    linecolor rgb '#000000' title 'setting of the study', \
  for [i=1:cheapest] name.'_cheapest.dat' using 1:4 with points pointtype 12 pointsize 2.1 linewidth 2 \
    linecolor rgb '#AA0000' notitle, \
  for [i=1:cheapest] NaN with points pointtype 12 pointsize 1 linewidth 2 \
    linecolor rgb '#AA0000' title 'cheapest within tolerance', \
  for [i=1:labels] name.'_labels.dat' using 1:2:4:('0x'.colour[$3][2:7] + 0) with labels font ',11' \
    textcolor rgb variable notitle
