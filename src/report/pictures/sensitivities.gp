# title: Sensitivities
# caption: Change in per cent of each budgeted value when a number of the roughness grows by one per cent, at
#   the solution. The longest bar is the number that matters most. The change stands beside its bar.
# alt: Bars of the sensitivity of each budget to each number of the roughness.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1000
load 'common.gp'

set title head('Change of budgets for +1 % of the roughness')
unset key; set grid noytics
set xlabel 'change of the value [%]'
set xrange [*<-0.1*longest:0.1*longest<*]; set offsets graph 0.03, graph 0.03, 0, 0
set yrange [bars+0.6:0.4]; set style fill solid 0.8 noborder; set boxwidth 0.6
set arrow from first 0, graph 0 to first 0, graph 1 nohead linecolor rgb 'black' linewidth 1 front
set ytics ('' 0); do for [k=1:bars] { set ytics add (bar[k] k) }
plot 'sensitivities.dat' using (0.5*$2):1:(0.5*abs($2)):(0.3) with boxxyerror linecolor rgb target_colour, \
  '' using ($2 > 0 ? $2 : 0):1:(sprintf('%+.3g', $2)) with labels left offset 0.8,0 font ',12'
