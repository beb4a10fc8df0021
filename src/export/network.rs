//! The network as a graph, in the formats of graph libraries and spreadsheets.

use std::fmt::Write as _;
use std::path::Path;

use serde::Serialize;
use serde_json::{Value, json};

use crate::error::{Error, Result};
use crate::plain_text::{Shown as _, in_csv};
use crate::sim::graph::{Between, Graph, Measures, Node};

/// A graph with what it is of.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct NetworkFile<'a> {
    /// The scene's name.
    pub scene: &'a str,
    /// Steps done.
    pub step: u64,
    /// The state's hash, 16 hexadecimal digits.
    pub state_hash: &'a str,
    /// The scene radius, world units: lengths and places are in multiples of it.
    pub radius: f64,
    /// The names of the objects.
    pub objects: &'a [String],
    /// The graph's measures.
    pub measures: &'a Measures,
    /// The graph.
    #[serde(flatten)]
    pub graph: &'a Graph,
}

/// A format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NetworkFormat {
    /// Everything, points of edges included.
    Json,
    /// For graph libraries, such as networkx, and for Gephi; without points of edges.
    GraphMl,
    /// A row for each edge.
    Csv,
}

impl NetworkFormat {
    /// By the ending of a path.
    ///
    /// # Errors
    /// When it has another ending.
    pub fn of(path: &Path) -> Result<Self> {
        let ending = path.extension().map(|ending| ending.to_ascii_lowercase());
        match ending.as_ref().and_then(|ending| ending.to_str()) {
            Some("json") => Ok(Self::Json),
            Some("graphml") => Ok(Self::GraphMl),
            Some("csv") => Ok(Self::Csv),
            _ => Err(Error::Invalid(format!(
                "{}: a network is written as .json, .graphml or .csv, or drawn as .png",
                path.shown()
            ))),
        }
    }
}

impl NetworkFile<'_> {
    /// The file's content.
    #[must_use]
    pub fn content(&self, format: NetworkFormat) -> String {
        match format {
            NetworkFormat::Json => {
                let text = serde_json::to_string(self).expect("its keys are texts");
                text + "\n"
            }
            NetworkFormat::GraphMl => self.graphml(),
            NetworkFormat::Csv => self.csv(),
        }
    }

    fn csv(&self) -> String {
        let mut text = "edge,from,to,length,way,width,trail,from_object,to_object,from_x,from_y,from_z,to_x,to_y,to_z\n".to_owned();
        for (number, edge) in self.graph.edges.iter().enumerate() {
            let [from, to] = [edge.from, edge.to].map(|node| &self.graph.nodes[node]);
            let [a, b] = [from, to].map(|node| in_csv(self.object(node)));
            let ([ax, ay, az], [bx, by, bz]) = (from.place, to.place);
            let _ = writeln!(
                text,
                "{number},{},{},{},{},{},{},{a},{b},{ax},{ay},{az},{bx},{by},{bz}",
                edge.from, edge.to, edge.length, edge.way, edge.width, edge.trail
            );
        }
        text
    }

    /// GraphML as Brandes et al. define it ("GraphML progress report", 2001).
    fn graphml(&self) -> String {
        const KEYS: &[(&str, &str, &str)] = &[
            ("node", "kind", "string"),
            ("node", "object", "string"),
            ("node", "width_at", "double"),
            ("node", "foods", "string"),
            ("node", "x", "double"),
            ("node", "y", "double"),
            ("node", "z", "double"),
            ("edge", "length", "double"),
            ("edge", "way", "double"),
            ("edge", "width", "double"),
            ("edge", "trail", "double"),
            ("graph", "scene", "string"),
            ("graph", "step", "long"),
            ("graph", "state_hash", "string"),
            ("graph", "radius", "double"),
        ];
        let mut text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
                        <graphml xmlns=\"http://graphml.graphdrawing.org/xmlns\">\n"
            .to_owned();
        for (of, name, kind) in KEYS {
            let _ = writeln!(
                text,
                "  <key id=\"{name}\" for=\"{of}\" attr.name=\"{name}\" attr.type=\"{kind}\"/>"
            );
        }
        text += "  <graph id=\"network\" edgedefault=\"undirected\">\n";
        let data = |text: &mut String, indent: &str, name: &str, value: &str| {
            let _ = writeln!(
                text,
                "{indent}<data key=\"{name}\">{}</data>",
                in_xml(value)
            );
        };
        for (name, value) in [
            ("scene", self.scene.to_owned()),
            ("step", self.step.to_string()),
            ("state_hash", self.state_hash.to_owned()),
            ("radius", self.radius.to_string()),
        ] {
            data(&mut text, "    ", name, &value);
        }
        for (number, node) in self.graph.nodes.iter().enumerate() {
            let _ = writeln!(text, "    <node id=\"{number}\">");
            let kind = json!(node.kind);
            data(
                &mut text,
                "      ",
                "kind",
                kind.as_str().unwrap_or_default(),
            );
            data(&mut text, "      ", "object", self.object(node));
            data(&mut text, "      ", "width_at", &node.width.to_string());
            let foods = node.foods.iter().map(ToString::to_string);
            data(
                &mut text,
                "      ",
                "foods",
                &foods.collect::<Vec<_>>().join(" "),
            );
            for (name, value) in ["x", "y", "z"].into_iter().zip(node.place) {
                data(&mut text, "      ", name, &value.to_string());
            }
            text += "    </node>\n";
        }
        for (number, edge) in self.graph.edges.iter().enumerate() {
            let (from, to) = (edge.from, edge.to);
            let _ = writeln!(
                text,
                "    <edge id=\"e{number}\" source=\"{from}\" target=\"{to}\">"
            );
            for (name, value) in [
                ("length", edge.length),
                ("way", edge.way),
                ("width", edge.width),
                ("trail", edge.trail),
            ] {
                data(&mut text, "      ", name, &value.to_string());
            }
            text += "    </edge>\n";
        }
        text + "  </graph>\n</graphml>\n"
    }

    fn object(&self, node: &Node) -> &str {
        &self.objects[node.object as usize]
    }
}

/// The measures of a graph as columns of tables: their names and values. Those between foods, from `foods_reached` on, are null where the
/// network reaches fewer than two; distances of single pairs are no columns.
#[must_use]
pub fn network_columns(measures: &Measures) -> Vec<(&'static str, Value)> {
    let foods = |of: fn(&Between) -> Value| measures.foods.as_ref().map_or(Value::Null, of);
    vec![
        ("nodes", json!(measures.nodes)),
        ("edges", json!(measures.edges)),
        ("junctions", json!(measures.junctions)),
        ("ends", json!(measures.ends)),
        ("parts", json!(measures.parts)),
        ("cycles", json!(measures.cycles)),
        ("mean_degree", json!(measures.mean_degree)),
        ("length", json!(measures.length)),
        ("width", json!(measures.width)),
        ("tolerance", json!(measures.tolerance)),
        ("foods_reached", foods(|foods| json!(foods.reached))),
        ("foods_connected", foods(|foods| json!(foods.connected))),
        ("foods_distance", foods(|foods| json!(foods.distance))),
        ("foods_efficiency", foods(|foods| json!(foods.efficiency))),
        ("foods_cost", foods(|foods| json!(foods.cost))),
        ("foods_tolerance", foods(|foods| json!(foods.tolerance))),
    ]
}

/// A text in XML; characters that XML cannot have become replacement characters.
fn in_xml(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '\t' | '\n' | '\r' => escaped.push(character),
            '\0'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => escaped.push('\u{fffd}'),
            _ => escaped.push(character),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Would catch: zeros in place of measures between foods that there are not.
    #[test]
    fn measures_between_foods_are_null_without_foods() {
        let mut measures = Measures {
            length: 2.5,
            ..Measures::default()
        };
        let value = |measures: &Measures, name: &str| {
            let columns = network_columns(measures);
            let column = columns.into_iter().find(|(own, _)| *own == name);
            column.expect("it is there").1
        };
        assert_eq!(value(&measures, "length"), json!(2.5));
        assert_eq!(value(&measures, "foods_reached"), Value::Null);
        measures.foods = Some(Between {
            reached: 2,
            ..Between::default()
        });
        assert_eq!(value(&measures, "foods_reached"), json!(2));
        assert_eq!(value(&measures, "foods_efficiency"), Value::Null);
    }
}
