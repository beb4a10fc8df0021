//! What ways to do the same take, side by side, as bars in an SVG.

use std::fmt::Write as _;

/// One way.
pub struct Bar {
    pub name: String,
    /// Bars of a colour are of the same way.
    pub color: usize,
    /// The value, and from where to where it may lie.
    pub value: f64,
    pub low: f64,
    pub high: f64,
    /// What else there is to say; stands behind the bar.
    pub note: String,
}

/// Colours that stay apart for the colour-blind (Okabe and Ito, "Color Universal Design", 2008).
const COLORS: [&str; 5] = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9"];

/// A picture; `label` is what lengths are, with the unit.
pub fn svg(title: &str, label: &str, bars: &[Bar]) -> String {
    const FROM: f64 = 340.0;
    const TO: f64 = 700.0;
    const TOP: f64 = 52.0;
    const ROW: f64 = 30.0;
    let most = bars.iter().map(|bar| bar.high.max(bar.value));
    let most = most.fold(f64::MIN_POSITIVE, f64::max);
    let place = |value: f64| FROM + value / most * (TO - FROM);
    let bottom = TOP + ROW * bars.len() as f64;
    let mut all = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"960\" height=\"{}\" font-family=\"sans-serif\" font-size=\"15\" \
         fill=\"#282C34\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        bottom + 64.0
    );
    let text = |x: f64, y: f64, anchor: &str, text: &str| {
        let text = text.replace('&', "&amp;").replace('<', "&lt;");
        format!("<text x=\"{x:.0}\" y=\"{y:.0}\" text-anchor=\"{anchor}\">{text}</text>\n")
    };
    all += &text(24.0, 32.0, "start", title);
    for (number, bar) in bars.iter().enumerate() {
        let top = TOP + ROW * number as f64;
        let middle = top + ROW / 2.0;
        let (low, high) = (place(bar.low), place(bar.high));
        let _ = writeln!(
            all,
            "<rect x=\"{FROM}\" y=\"{}\" width=\"{:.1}\" height=\"{}\" fill=\"{}\"/>\n\
             <path d=\"M{low:.1} {middle}H{high:.1}M{low:.1} {a}V{b}M{high:.1} {a}V{b}\" stroke=\"#282C34\"/>",
            top + 3.0,
            place(bar.value) - FROM,
            ROW - 6.0,
            COLORS[bar.color % COLORS.len()],
            a = middle - 4.0,
            b = middle + 4.0,
        );
        all += &text(FROM - 10.0, middle + 5.0, "end", &bar.name);
        let behind = place(bar.high.max(bar.value)) + 8.0;
        all += &text(behind, middle + 5.0, "start", &bar.note);
    }
    let _ = writeln!(
        all,
        "<path d=\"M{FROM} {TOP}V{bottom}H{TO}\" stroke=\"#282C34\" fill=\"none\"/>"
    );
    all += &text(FROM, bottom + 20.0, "middle", "0");
    all += &text(TO, bottom + 20.0, "middle", &format!("{most:.0}"));
    all += &text((FROM + TO) / 2.0, bottom + 44.0, "middle", label);
    all + "</svg>\n"
}
