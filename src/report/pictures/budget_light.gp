# title: Encircled energy and budget
# caption: Encircled energy by theory over a logarithmic radius: for the study as it stands, for the roughness
#   that was found, and for the mirror without roughness. A mark is a budget for encircled energy. The curve
#   of the solution passes on its left, or through it where that budget is the limit.
# alt: Encircled energy over logarithmic radius with the budget marked.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1100; height = 750
load 'common.gp'

set title head('Encircled energy and the budget')
eval r_axis
set yrange [0:1.03]; set ytics 0.1
set xlabel axis('radius', r_unit); set ylabel 'encircled energy'
set key inside top left vertical
set style textbox opaque noborder
do for [k=1:marks] {
  set arrow from first radius[k]*r_scale, graph 0 to first radius[k]*r_scale, first fraction[k] nohead \
    linecolor rgb 'black' linewidth 1 dashtype 2
  set label budget[k] at first radius[k]*r_scale, graph (0.05*k) right offset -0.8,0 boxed
}
plot 'budget_light.dat' using ($1*r_scale):2 with lines linetype 1 title 'without roughness', \
  '' using ($1*r_scale):3 with lines linetype 3 title 'the study as it stands', \
  for [i=1:solved] '' using ($1*r_scale):4 with lines linetype 2 title 'the solution', \
  for [k=1:marks] '+' using (radius[k]*r_scale):(fraction[k]) every ::0::0 with points pointtype 7 \
    pointsize 1.3 linecolor rgb 'black' notitle
