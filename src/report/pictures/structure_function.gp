# title: Structure function
# caption: Mean square difference of two heights over their separation, for the detrended measurement and for
#   the fitted model in its band. It needs no window and no transform, so it is an independent check of the
#   PSD.
# alt: Structure function of measurement and model over separation.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1200; height = 800
load 'common.gp'

set title head('Structure function, detrended')
eval x_axis; eval y_axis
set xlabel 'separation s [mm]'; set ylabel 'mean square difference D(s) [nm²]'
set key inside bottom right vertical
plot for [i=1:files] 'structure_function.dat' index i-1 using ($1*1e3):($2*1e18) with points \
    pointtype (5+2*i) pointsize 0.9 linecolor rgb target_colour \
    title (files > 1 ? sprintf('measured, file %d', i) : 'measured'), \
  for [i=1:files] 'structure_function.dat' index i-1 using ($1*1e3):($3*1e18) with lines linetype 3 \
      dashtype 1 \
    title (i == 1 ? 'model in its band: '.model : '')
