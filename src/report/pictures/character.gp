# title: Character of the surface
# caption: The fitted surface compared with random realisations of its roughness. Left, its PSD over that of
#   the specification; right, the RMS slope of zones of the aperture. A surface inside the bands looks like
#   this roughness; it does not only have the same focus.
# alt: PSD and slopes of the fitted surface with the bands that hold 99 % of realisations.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1200; height = 720
load 'common.gp'

set multiplot layout 1,(1+has_psd) title head('The surface and realisations of its roughness') font ',16'
if (has_psd) {
  set logscale y; eval f_axis
  set xlabel 'spatial frequency [cycles/m]'; set ylabel 'PSD over that of the specification'
  set yrange [*<0.3:3<*]; set ytics (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50)
  plot 'character_psd.dat' using (sqrt($1*$2)):5:6 with filledcurves fillcolor rgb '#cfe3f1' \
      title '99 % of realisations', \
    '' using (sqrt($1*$2)):4 with lines linetype 2 title 'their mean', \
    '' using (sqrt($1*$2)):3 with linespoints linecolor rgb fitted_colour linewidth 2 pointtype 7 title \
        'fitted'
}
unset logscale; set xtics autofreq; set ytics autofreq; set xrange [0:1]; set yrange [*<0.8:1.2<*]
set xlabel 'distance from the axis [aperture radii]'; set ylabel 'RMS slope over that of the aperture'
plot 'character_zones.dat' using (0.5*($1+$2)):5:6 with filledcurves fillcolor rgb '#cfe3f1' \
    title '99 % of realisations', \
  '' using (0.5*($1+$2)):4 with lines linetype 2 title 'their mean', \
  '' using (0.5*($1+$2)):3 with linespoints linecolor rgb fitted_colour linewidth 2 pointtype 7 title 'fitted'
unset multiplot
