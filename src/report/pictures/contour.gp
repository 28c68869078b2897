# title: Where the budget is met
# caption: Curve of the two unknowns on which the strictest budget is met exactly. The key says on which side
#   of it the budgets hold. The cross is the study as it stands, the square the solution for its second
#   unknown.
# alt: Contour of two numbers of the roughness on which the budget is met.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1000; height = 750
load 'common.gp'

set title head('Budget met exactly')
eval x_axis; eval y_axis
set xlabel axis(x_name, x_unit); set ylabel axis(y_name, y_unit)
plot 'contour.dat' using ($1*x_scale):($2*y_scale) with lines linetype 2 title budgets, \
  '' using ($1*x_scale):($2*y_scale) with points pointtype 7 pointsize 0.5 linecolor rgb target_colour \
      notitle, \
  'contour_marks.dat' index 0 using ($1*x_scale):($2*y_scale) with points pointtype 2 pointsize 2 \
      linewidth 2.5 \
    linecolor rgb fitted_colour title 'the study', \
  for [i=1:solved] 'contour_marks.dat' index 1 using ($1*x_scale):($2*y_scale) with points pointtype 4 \
    pointsize 2 linewidth 2 linecolor rgb 'black' title 'the solution'
