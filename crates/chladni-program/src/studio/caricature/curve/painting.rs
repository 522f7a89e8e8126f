//! Draws the curve, with the spectrum that the active model exaggerates behind it.

use chladni_caricature::ScaleCurve;
use egui::{Color32, Pos2, Rect, Stroke, Ui, pos2, vec2};

use super::Pen;
use super::plot::{Plot, height_of, to_screen};
use crate::studio::theme;
use crate::work::scale_plot::{GAINS, Spectrum, wave_at};

/// Wavelengths that are named below the plot, shares of the size.
const WAVES: [f64; 6] = [2.0, 1.0, 0.5, 0.2, 0.1, 0.05];

/// Draws the plot and its contents.
pub(super) fn paint(ui: &Ui, rect: Rect, plot: Plot, curve: &ScaleCurve, spectrum: &Spectrum, pen: Pen) {
    let palette = theme::palette(ui);
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 6.0, ui.visuals().extreme_bg_color);
    let faint = Stroke::new(1.0, palette.line.gamma_multiply(0.7));
    let font = egui::FontId::proportional(10.5);
    for gain in GAINS {
        let y = height_of(plot.curve, gain);
        painter.hline(plot.curve.x_range(), y, faint);
        painter.hline(plot.residual.x_range(), y, faint);
        // Gains are written left of the plot, not over lines.
        let at = pos2(rect.left() + 5.0, y);
        painter.text(at, egui::Align2::LEFT_CENTER, format!("×{gain:.0}"), font.clone(), palette.weak);
    }
    let foot = plot.curve.bottom() + 3.0;
    for wavelength in WAVES {
        let x = to_screen(plot.curve, [wavelength, 0.0]).x;
        painter.vline(x, plot.curve.y_range(), faint);
        painter.text(
            pos2(x, foot),
            egui::Align2::CENTER_TOP,
            percent_tick(wavelength),
            font.clone(),
            palette.weak,
        );
    }
    let finer = pos2(plot.residual.center().x, foot);
    painter.text(finer, egui::Align2::CENTER_TOP, "finer", font, palette.weak);
    if spectrum.waves.is_empty() {
        let font = egui::FontId::proportional(11.5);
        let text = "the difference appears here";
        let at = plot.curve.center_top() + vec2(0.0, 10.0);
        painter.text(at, egui::Align2::CENTER_TOP, text, font, palette.weak);
    }
    paint_bars(
        &painter,
        plot,
        curve,
        spectrum,
        palette.weak.gamma_multiply(0.4),
        palette.accent.gamma_multiply(0.5),
    );
    paint_curve(ui, &painter, plot, curve, spectrum, pen);
}

fn percent_tick(wavelength: f64) -> String {
    format!("{:.0}%", 100.0 * wavelength)
}

/// The curve: strong where there are harmonics, faint where there would be only with more of them.
fn paint_curve(
    ui: &Ui,
    painter: &egui::Painter,
    plot: Plot,
    curve: &ScaleCurve,
    spectrum: &Spectrum,
    pen: Pen,
) {
    let palette = theme::palette(ui);
    let steps = (plot.curve.width() / 2.0).ceil().max(2.0) as usize;
    let line: Vec<Pos2> = (0..=steps)
        .map(|i| {
            let wavelength = wave_at(i as f64 / steps as f64);
            to_screen(plot.curve, [wavelength, curve.at(wavelength)])
        })
        .collect();
    let reached = ((spectrum.finest() * steps as f64).ceil() as usize).min(steps);
    // A rim keeps it apart from bars of its color.
    let rim = Stroke::new(5.0, ui.visuals().extreme_bg_color);
    painter.line(line.clone(), rim);
    painter.line(line[reached..].to_vec(), Stroke::new(1.5, palette.weak.gamma_multiply(0.7)));
    painter.line(line[..=reached].to_vec(), Stroke::new(2.0, palette.accent));
    let handle = |at: Pos2| {
        painter.circle(at, 4.0, ui.visuals().panel_fill, Stroke::new(2.0, palette.accent));
    };
    let y = height_of(plot.residual, curve.residual);
    for stroke in [rim, Stroke::new(2.0, palette.accent)] {
        painter.hline(plot.residual.x_range(), y, stroke);
    }
    handle(pos2(plot.residual.center().x, y));
    if pen == Pen::Points {
        curve.points.iter().for_each(|point| handle(to_screen(plot.curve, *point)));
    }
}

/// The energy of each band of wavelengths before and after the curve. The residual is an extra band.
fn paint_bars(
    painter: &egui::Painter,
    plot: Plot,
    curve: &ScaleCurve,
    spectrum: &Spectrum,
    before: Color32,
    after: Color32,
) {
    let bands = (plot.curve.width() / 6.0).max(1.0) as usize;
    let bar = |x: egui::Rangef, heights: [f64; 2]| {
        for (height, color) in heights.into_iter().zip([before, after]) {
            let height = plot.curve.height() * height as f32;
            let y = egui::Rangef::new(plot.curve.bottom() - height, plot.curve.bottom());
            if height > 0.0 {
                painter.rect_filled(Rect::from_x_y_ranges(x, y), 1.0, color);
            }
        }
    };
    let width = plot.curve.width() / bands as f32;
    for (band, heights) in spectrum.bars(curve, bands).into_iter().enumerate() {
        let left = plot.curve.left() + width * band as f32;
        let x = egui::Rangef::new(left + 0.5, left + width - 0.5);
        bar(if band < bands { x } else { plot.residual.x_range().shrink(3.0) }, heights);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rim_of_the_ground_lies_beneath_the_whole_curve() {
        let (ctx, mut ground) = (egui::Context::default(), Color32::TRANSPARENT);
        theme::install(&ctx);
        let output = ctx.run_ui(egui::RawInput::default(), |ui| {
            ground = ui.visuals().extreme_bg_color;
            let rect = Rect::from_min_size(Pos2::ZERO, vec2(280.0, 180.0));
            paint(ui, rect, Plot::within(rect), &ScaleCurve::mid(), &Spectrum::default(), Pen::Free);
        });
        let mut lines = output.shapes.iter().filter_map(|clipped| match &clipped.shape {
            egui::Shape::Path(path) => Some(path),
            _ => None,
        });
        let rim = lines.next().unwrap();
        assert_eq!(rim.stroke.color, epaint::ColorMode::Solid(ground));
        for line in lines {
            assert!(line.stroke.width + 2.0 <= rim.stroke.width);
            assert!(line.points.iter().all(|point| rim.points.contains(point)));
        }
    }
}
