//! A plain program of the agents of J. Jones, "Characteristics of pattern formation and evolution in approximations of Physarum transport
//! networks", Artificial Life 16(2), 2010: agents one after the other on a square of cells that wraps around. It is written from the paper
//! alone, shares no line with the library, and is slow and short, so that it can be read beside the paper.
//!
//! What the paper says: one agent a cell; in each step first all agents do their motor stage, then all their sensory stage, then the trail
//! is filtered by the mean of 3 x 3 cells and decays. "Influences on the formation and evolution of Physarum polycephalum inspired emergent
//! transport networks", Natural Computing 10(4), 2011, adds that the mean is multiplied by 1 - d, with d = 0.1.
//!
//! What it leaves open, and what is chosen here:
//! - *Places in a cell.* Headings are any angle, and steps are one cell long. So places must keep their fractions: an agent that began each
//!   step from the middle of its cell could only go in eight directions. A cell has the places whose whole parts are its column and row. To
//!   round instead moves the cells by half of one, and changes nothing else.
//! - *A step that ends in the agent's own cell*, as steps slantwise may. No other agent is there, so it counts as a move, and it deposits.
//! - *Where agents begin*: in cells drawn without repetition, anywhere in the cell, with any heading.
//! - *The order of agents* in a stage: see [`Order`]. Only the motor stage can tell, because sensing changes nothing that others sense.
//! - *Deposits* are in the trail at once, so that sensors read them before they are filtered.

/// In which order agents move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Shuffled again in each step.
    Random,
    /// The same in all steps.
    Fixed,
}

/// A rule that is not the paper's, by which a comparison can be tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// As in the paper.
    None,
    /// Agents that could not move deposit where they are.
    DepositsAnyway,
    /// Agents that could not move keep their heading.
    KeepsHeading,
    /// If both sides read more than the middle, an agent turns to the side that reads more.
    TurnsToMore,
    /// Any number of agents may be in one cell.
    SharesCells,
}

/// The parameters, by the paper's names, with its values.
#[derive(Clone, Copy, Debug)]
pub struct Parameters {
    /// Columns, and rows.
    pub side: usize,
    /// %p: agents, as a share of the cells.
    pub population: f64,
    /// SA: degrees from the middle sensor to those beside it.
    pub sensor_angle: f64,
    /// RA: degrees of a turn.
    pub rotation_angle: f64,
    /// SO: cells from an agent to its sensors.
    pub sensor_offset: f64,
    /// SS: cells that an agent moves in a step.
    pub step_size: f64,
    /// depT: trail that an agent leaves.
    pub deposit: f64,
    /// decayT: the share of the trail that a step takes.
    pub decay: f64,
    pub order: Order,
    pub change: Change,
}

impl Parameters {
    /// The paper's, with these angles.
    pub fn of(sensor_angle: f64, rotation_angle: f64, order: Order) -> Self {
        Self {
            side: 200,
            population: 0.15,
            sensor_angle,
            rotation_angle,
            sensor_offset: 9.0,
            step_size: 1.0,
            deposit: 5.0,
            decay: 0.1,
            order,
            change: Change::None,
        }
    }
}

#[derive(Clone, Copy, Debug)]
struct Agent {
    x: f64,
    y: f64,
    /// Degrees.
    heading: f64,
}

/// The agents, the cells that they are in, and the trail.
pub struct Plain {
    parameters: Parameters,
    agents: Vec<Agent>,
    /// The numbers of the agents, in the order in which they move.
    order: Vec<usize>,
    /// Per cell, row by row: agents in it.
    occupants: Vec<u32>,
    /// Per cell: the trail after the filter.
    trail: Vec<f64>,
    /// Per cell: the trail that the sensors of the last step have read.
    sensed: Vec<f64>,
    refused: usize,
    random: Random,
}

impl Plain {
    pub fn new(parameters: Parameters, seed: u64) -> Self {
        let cells = parameters.side * parameters.side;
        let mut random = Random(seed);
        let mut all: Vec<usize> = (0..cells).collect();
        random.shuffle(&mut all);
        all.truncate((parameters.population * cells as f64).round() as usize);
        let mut occupants = vec![0; cells];
        let agents = all.iter().map(|&cell| {
            occupants[cell] = 1;
            Agent {
                x: (cell % parameters.side) as f64 + random.share(),
                y: (cell / parameters.side) as f64 + random.share(),
                heading: 360.0 * random.share(),
            }
        });
        let agents: Vec<Agent> = agents.collect();
        Self {
            parameters,
            order: (0..agents.len()).collect(),
            agents,
            occupants,
            trail: vec![0.0; cells],
            sensed: vec![0.0; cells],
            refused: 0,
            random,
        }
    }

    /// One step of the scheduler.
    pub fn step(&mut self) {
        if self.parameters.order == Order::Random {
            self.random.shuffle(&mut self.order);
        }
        self.refused = 0;
        for k in 0..self.order.len() {
            self.motor_stage(self.order[k]);
        }
        for k in 0..self.order.len() {
            self.sensory_stage(self.order[k]);
        }
        let filtered = self.filtered();
        self.sensed = std::mem::replace(&mut self.trail, filtered);
    }

    /// The agent attempts a step.
    fn motor_stage(&mut self, number: usize) {
        let agent = self.agents[number];
        let (x, y) = self.ahead(agent, 0.0, self.parameters.step_size);
        let (from, to) = (self.cell(agent.x, agent.y), self.cell(x, y));
        let change = self.parameters.change;
        if to == from || self.occupants[to] == 0 || change == Change::SharesCells {
            self.occupants[from] -= 1;
            self.occupants[to] += 1;
            self.agents[number].x = x;
            self.agents[number].y = y;
            self.trail[to] += self.parameters.deposit;
        } else {
            self.refused += 1;
            if change != Change::KeepsHeading {
                self.agents[number].heading = 360.0 * self.random.share();
            }
            if change == Change::DepositsAnyway {
                self.trail[from] += self.parameters.deposit;
            }
        }
    }

    /// The agent samples the trail by its three sensors, and turns.
    fn sensory_stage(&mut self, number: usize) {
        let agent = self.agents[number];
        let sample = |degrees: f64| {
            let (x, y) = self.ahead(agent, degrees, self.parameters.sensor_offset);
            self.trail[self.cell(x, y)]
        };
        let (sensor_angle, rotation_angle) =
            (self.parameters.sensor_angle, self.parameters.rotation_angle);
        let left = sample(sensor_angle);
        let middle = sample(0.0);
        let right = sample(-sensor_angle);
        let turn = if middle > left && middle > right {
            0.0
        } else if middle < left && middle < right {
            let is_left = match self.parameters.change {
                Change::TurnsToMore => left > right,
                _ => self.random.share() < 0.5,
            };
            if is_left {
                rotation_angle
            } else {
                -rotation_angle
            }
        } else if left < right {
            -rotation_angle
        } else if right < left {
            rotation_angle
        } else {
            0.0
        };
        self.agents[number].heading += turn;
    }

    /// The mean of 3 x 3 cells, less what decays.
    fn filtered(&self) -> Vec<f64> {
        let side = self.parameters.side;
        let mut filtered = vec![0.0; side * side];
        for row in 0..side {
            let rows = [(row + side - 1) % side, row, (row + 1) % side];
            for column in 0..side {
                let columns = [(column + side - 1) % side, column, (column + 1) % side];
                let mut sum = 0.0;
                for row in rows {
                    for column in columns {
                        sum += self.trail[row * side + column];
                    }
                }
                filtered[row * side + column] = sum / 9.0 * (1.0 - self.parameters.decay);
            }
        }
        filtered
    }

    /// The place so far from an agent, so many degrees to the left of its heading.
    fn ahead(&self, agent: Agent, degrees: f64, distance: f64) -> (f64, f64) {
        let (sin, cos) = (agent.heading + degrees).to_radians().sin_cos();
        let side = self.parameters.side as f64;
        (
            (agent.x + distance * cos).rem_euclid(side),
            (agent.y + distance * sin).rem_euclid(side),
        )
    }

    /// The cell with a place.
    fn cell(&self, x: f64, y: f64) -> usize {
        let side = self.parameters.side;
        // What lies below 0 by less than a rounding is the side itself, after the wrap.
        (y as usize % side) * side + x as usize % side
    }

    /// Per cell, row by row: the trail as the sensors of the last step have read it.
    pub fn sensed(&self) -> &[f64] {
        &self.sensed
    }

    /// Agents that could not move in the last step, as a share.
    pub fn refused(&self) -> f64 {
        self.refused as f64 / self.agents.len() as f64
    }

    /// Agents that are in a cell with another one. They are counted by their places, not by what the program keeps of cells.
    pub fn sharing(&self) -> usize {
        let mut cells: Vec<usize> = self.agents.iter().map(|a| self.cell(a.x, a.y)).collect();
        cells.sort_unstable();
        cells.dedup();
        self.agents.len() - cells.len()
    }
}

/// SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014), which no kernel uses.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// From 0 to 1, without 1.
    fn share(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Fisher and Yates, as in Durstenfeld, "Algorithm 235: random permutation", CACM 7(7), 1964.
    fn shuffle(&mut self, items: &mut [usize]) {
        for last in (1..items.len()).rev() {
            let other = (self.share() * (last + 1) as f64) as usize;
            items.swap(last, other);
        }
    }
}
