//! `myxo sweep`: the runs of a study, by several processes. Each process is this program again: it reads jobs from its standard input and
//! writes a row for each to its standard output, a line of JSON each behind a mark, and after it the run's picture, if runs have pictures.
//! A process that dies takes one run with it and no others.

mod sheet;

use std::collections::HashMap;
use std::io::{self, BufRead, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command as Process, Stdio};
use std::str::FromStr;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use std::{thread, vec};

use clap::Args;
use myxo::gpu::{Context, ContextOptions, DeviceKind, default_cache_folder};
use myxo::plain_text::{Shown as _, escaped};
use myxo::sweep::{
    Finished, Folder, Job, Picture, Row, Shard, Study, check_keys, check_pictures, largest,
    processes, threads,
};
use myxo::{Error, Result};
use serde::{Deserialize, Serialize};

use super::progress::Progress;
use super::{Command, Outcome, interrupt};
use crate::console;
use sheet::Sheet;

/// A run whose process dies is begun again until it was tried so often.
const ATTEMPTS: usize = 3;
/// So many errors of runs are printed; all are in the folder.
const PRINTED: usize = 5;
/// Begins an answer of a process: layers and drivers may print lines of their own into its standard output.
const MARK: &str = "myxo-sweep-answer ";

/// Run a scene at many points of its parameters, and write a table of them
///
/// A study file names the scene and the points: a grid, a sample or a list. Each run that is done is written at once, so
/// the same command goes on where an earlier one was ended, and runs nothing twice. The folder gets table.csv and table.parquet,
/// with a row for each run: its parameters, measures of its network, the hash of its state, the program's commit, and its error if it
/// failed.
///
/// With `network = true` in the study rows also have the measures of the network as a graph, those of `myxo network --series`, from
/// graph_nodes to graph_foods_tolerance. Rows without them are done again.
///
/// With `picture` in the study each run also writes a picture, pictures/KEY.png, and a grid a sheet of them, sheet.png: its first parameter
/// changes from row to row, its last one from column to column.
///
/// A picture that cannot be drawn leaves its run's row as it is, and is not tried again, unless by --retry.
///
/// Exits 1 if a run has failed, or has no picture.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  myxo sweep angles.toml --out angles
  myxo sweep angles.toml --out angles --shard 3/100   one part of a job array, for $SLURM_ARRAY_TASK_ID = 3
  myxo sweep angles.toml --out angles --retry         failed runs again

A study:
  scene = \"plane\"             # a built-in name, a scene file or a model
  steps = 400
  seeds = 3                   # 0, 1 and 2; or a list
  preset = \"network\"
  picture = \"240x240\"        # of each run, and a sheet of a grid's
  network = true              # also measures of the graph
  set.\"particles.count\" = 100000
  [grid]                      # every combination
  \"physarum.sensor_angle\" = [15, 30, 45]
  \"physarum.rotation_angle\" = [15, 30, 45]

In place of [grid]:
  [sample]                    # points within ranges
  count = 100
  method = \"latin\"            # or sobol, random
  ranges.\"physarum.speed\" = [0.002, 0.01]

  [[point]]                   # a list
  \"trail.decay\" = 0.9")]
pub struct Sweep {
    /// The study file
    #[arg(value_name = "STUDY")]
    study: PathBuf,
    /// The folder for rows and tables; it is made if it is missing
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// How many runs at once; by default as many as there are cores and memory for, on a graphics card one
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    workers: Option<u16>,
    /// Only each N-th run from the I-th on, counted from 0: all shards share a folder
    #[arg(long, value_name = "I/N")]
    shard: Option<Part>,
    /// Runs failed runs again, and those whose picture could not be drawn
    #[arg(long)]
    retry: bool,
    /// Computes on this device: its number or a part of its name, as `myxo info` lists them
    #[arg(long, value_name = "N|NAME")]
    device: Option<String>,
}

/// `--shard`.
#[derive(Clone, Copy, Debug)]
struct Part(Shard);

impl FromStr for Part {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(number, of)| {
            let number = number.trim().parse().ok()?;
            Some((number, of.trim().parse().ok()?))
        });
        let Some((number, of)) = numbers else {
            return Err("I/N is expected, such as 0/4".to_owned());
        };
        Shard::new(number, of)
            .map(Self)
            .map_err(|error| error.to_string())
    }
}

impl Command for Sweep {
    fn run(&self) -> Result<Outcome> {
        let study = Study::read(&self.study)?;
        let keys = study
            .settings
            .0
            .iter()
            .chain(study.points.iter().flat_map(|point| &point.0));
        check_keys(keys.map(|(key, _)| key.as_str()), "`myxo scenes --keys`")
            .map_err(|error| Error::Invalid(format!("{}: {error}", self.study.shown())))?;
        let (fixed, jobs) = study.jobs()?;
        let sheet = Sheet::of(&study, &jobs);
        let runs = jobs
            .iter()
            .map(|job| (job.key.clone(), job.number))
            .collect();
        let shard = self.shard.map_or(Shard::WHOLE, |part| part.0);
        let jobs = shard.part(jobs);
        let folder = Folder::claim(&self.out, &fixed, shard)?;
        let mut missing = Vec::new();
        for job in &jobs {
            if !folder.is_done(&job.key, job.picture, self.retry)? {
                missing.push(job.clone());
            }
        }
        if let Some(problem) = sheet.as_ref().and_then(Sheet::too_large) {
            console::message(&problem);
        }
        let mut problems = Problems::default();
        if !missing.is_empty() {
            interrupt::install_with("waiting for the runs under way", || {})?;
            let workers = self.workers(&missing)?;
            let name = self.study.file_stem().unwrap_or_default().to_string_lossy();
            let mut progress = Progress::counting(missing.len() as u64, &name, "runs");
            console::message(&format!(
                "{} of {} runs to do, by {} process{}",
                missing.len(),
                jobs.len(),
                workers.count,
                if workers.count == 1 { "" } else { "es" }
            ));
            let result = workers.run(missing, |finished| {
                progress.step();
                keep(&folder, finished, study.picture, |run, problem| {
                    problems.print(run, problem, &progress);
                })
            });
            progress.finish();
            // What is done is in the table, whatever ended the sweep.
            let written = folder.write_table(&runs);
            result?;
            written?;
        }
        if problems.count > PRINTED {
            console::message(&format!("and {} more errors", problems.count - PRINTED));
        }
        self.end(&folder, &jobs, &runs, study.picture, sheet.as_ref())
    }
}

impl Sweep {
    /// Opens the device once, to learn what it is, and whether it can draw the pictures.
    fn workers(&self, jobs: &[Job]) -> Result<Workers> {
        let ctx = open(self.device.clone())?;
        let info = ctx.info();
        let largest = Job {
            point: largest(jobs.iter().map(|job| &job.point)),
            ..jobs[0].clone()
        };
        // A scene that cannot be loaded is a row with its error.
        let is_needed = self.workers.is_none() || largest.picture.is_some();
        let scene = is_needed.then(|| largest.scene().ok()).flatten();
        if let Some(size) = largest.picture {
            let has_one_view = |job: &Job| job.point.get("picture.show").is_none();
            let seen = scene.as_ref().filter(|_| jobs.iter().all(has_one_view));
            let option = format!("`picture` in {}", self.study.shown());
            check_pictures(Some(&ctx), seen, largest.steps, size, &option)?;
        }
        let fitting = || {
            let scene = scene.as_ref();
            scene.map_or(1, |scene| processes(info, scene, largest.picture))
        };
        let count = self.workers.map_or_else(fitting, usize::from);
        let count = count.min(jobs.len());
        let is_shared = count > 1 && info.kind == DeviceKind::Cpu;
        Ok(Workers {
            count,
            threads: is_shared.then(|| threads(count)),
            device: self.device.clone(),
        })
    }

    fn end(
        &self,
        folder: &Folder,
        jobs: &[Job],
        runs: &HashMap<String, usize>,
        picture: Option<[u32; 2]>,
        sheet: Option<&Sheet>,
    ) -> Result<Outcome> {
        let (mut done, mut failed, mut without) = (0, 0, 0);
        for job in jobs {
            if !folder.is_done(&job.key, job.picture, false)? {
                continue;
            }
            done += 1;
            if !folder.has(&job.key, true)? {
                failed += 1;
            } else if picture.is_some_and(|size| !folder.has_picture(&job.key, size)) {
                without += 1;
            }
        }
        if done < jobs.len() {
            console::message(&format!(
                "{done} of {} runs done: the same command goes on",
                jobs.len()
            ));
            return Ok(Outcome::Interrupted);
        }
        // Another shard may have been killed before it wrote the table.
        let files = folder.write_table(runs)?;
        let failures = match failed {
            0 => String::new(),
            failed => format!(", {failed} failed (--retry)"),
        };
        let lacking = match without {
            0 => String::new(),
            without => format!(", {without} without a picture (--retry)"),
        };
        let files = files.each_ref().map(|file| file.shown());
        console::message(&format!(
            "{done} runs done{failures}{lacking}: {} and {}",
            files[0], files[1]
        ));
        if let Some(sheet) = sheet {
            draw(sheet, folder, runs)?;
        }
        Ok(if failed + without > 0 {
            Outcome::Failed
        } else {
            Outcome::Done
        })
    }
}

/// Keeps what a run leaves, and says by `print` what is wrong with it: the number of the run, and the problem.
fn keep(
    folder: &Folder,
    Finished { row, picture }: Finished,
    size: Option<[u32; 2]>,
    mut print: impl FnMut(u64, &str),
) -> Result<()> {
    let text = |name| row.get(name).and_then(|value| value.as_str());
    let key = text("key").unwrap_or_default();
    let run = row.get("run").and_then(|run| run.as_u64());
    let mut print = |problem: &str| print(run.unwrap_or_default(), problem);
    // A good row stays if its run, done again for the picture, fails.
    let stays = row.failed() && folder.has(key, true)?;
    let error = text("error").unwrap_or_default();
    let picture = match picture {
        _ if stays => Some(Err(error.to_owned())),
        picture => picture,
    };
    match (picture, size) {
        (Some(Ok(png)), _) => folder.keep_picture(key, &png)?,
        (Some(Err(why)), Some(size)) => {
            print(&format!("no picture: {why}"));
            folder.keep_undrawn(key, size, &why)?;
        }
        _ => {}
    }
    if stays {
        return Ok(());
    }
    if row.failed() {
        print(error);
    }
    folder.keep(key, &row, None)
}

/// Draws the sheet, or says why there is none; of one that is too large that was said at the beginning.
fn draw(sheet: &Sheet, folder: &Folder, runs: &HashMap<String, usize>) -> Result<()> {
    let mut rows = 0;
    for key in runs.keys() {
        rows += usize::from(folder.has(key, false)?);
    }
    if sheet.too_large().is_some() {
        // One that is there is of other runs, or of pictures of another size.
        return folder.remove_sheet();
    }
    if rows < runs.len() {
        console::message(&format!(
            "no sheet.png yet: {rows} of the study's {} runs are done; the last shard draws it",
            runs.len()
        ));
        return folder.remove_sheet();
    }
    // Runs of another shard may be from a time when the study had no pictures.
    if !sheet.is_ready(folder)? {
        console::message(
            "no sheet.png: runs of other shards have no pictures yet: the same command for those shards draws them",
        );
        return folder.remove_sheet();
    }
    let file = folder.keep_sheet(&sheet.png(folder)?)?;
    console::message(&format!("a sheet of their pictures: {}", file.shown()));
    Ok(())
}

/// What is wrong with runs; the first few are printed.
#[derive(Default)]
struct Problems {
    count: usize,
}

impl Problems {
    fn print(&mut self, run: u64, problem: &str, progress: &Progress) {
        self.count += 1;
        if self.count <= PRINTED {
            progress.say(&format!("run {run}: {}", escaped(problem)));
        }
    }
}

fn open(device: Option<String>) -> Result<Arc<Context>> {
    Ok(Context::new(&ContextOptions {
        device,
        cache_folder: default_cache_folder(),
        ..ContextOptions::default()
    })?)
}

/// Processes that do runs.
struct Workers {
    count: usize,
    /// Of each, where they compute on the processor side by side.
    threads: Option<usize>,
    device: Option<String>,
}

impl Workers {
    /// Does all jobs, and passes on what each leaves as soon as it is there. After Ctrl-C or an error of `keep` no more are begun.
    fn run(&self, jobs: Vec<Job>, mut keep: impl FnMut(Finished) -> Result<()>) -> Result<()> {
        let program = std::env::current_exe().map_err(Error::io("find", "myxo"))?;
        let jobs = Mutex::new(jobs.into_iter());
        let (send, results) = channel();
        let stop = Mutex::new(None);
        thread::scope(|scope| {
            for _ in 0..self.count {
                let (send, jobs, program) = (send.clone(), &jobs, &program);
                let stop = &stop;
                scope.spawn(move || self.work(program, jobs, stop, &send));
            }
            drop(send);
            for result in results {
                let kept = result.and_then(&mut keep);
                if let Err(error) = kept {
                    stop.lock()
                        .unwrap_or_else(PoisonError::into_inner)
                        .get_or_insert(error);
                }
            }
        });
        let stopped = stop.into_inner().unwrap_or_else(PoisonError::into_inner);
        stopped.map_or(Ok(()), Err)
    }

    /// Does jobs by one process, until there are none left.
    fn work(
        &self,
        program: &Path,
        jobs: &Mutex<vec::IntoIter<Job>>,
        stop: &Mutex<Option<Error>>,
        send: &Sender<Result<Finished>>,
    ) {
        let mut worker = None;
        loop {
            let is_stopped = stop.lock().map_or(true, |stop| stop.is_some());
            if is_stopped || interrupt::requested() {
                break;
            }
            let next = jobs.lock().unwrap_or_else(PoisonError::into_inner).next();
            let Some(job) = next else { break };
            let result = match self.attempt(program, &mut worker, &job) {
                Ok(None) => break,
                Ok(Some(finished)) => Ok(finished),
                Err(error) => Err(error),
            };
            let is_error = result.is_err();
            if send.send(result).is_err() || is_error {
                break;
            }
        }
    }

    /// What a job leaves; none if its process has died and the sweep is to end. Fails only if no process can be begun.
    fn attempt(
        &self,
        program: &Path,
        worker: &mut Option<Worker>,
        job: &Job,
    ) -> Result<Option<Finished>> {
        let mut ended = String::new();
        for _ in 0..ATTEMPTS {
            let current = match worker.take() {
                Some(current) => current,
                None => self.begin(program).map_err(Error::io("start", program))?,
            };
            match current.run(job) {
                Ok((finished, current)) => {
                    *worker = Some(current);
                    return Ok(Some(finished));
                }
                Err(how) => ended = how,
            }
            // A batch system ends all processes of a job, and this one learns of it after the others.
            thread::sleep(Duration::from_millis(100));
            if interrupt::requested() {
                return Ok(None);
            }
        }
        let row = job.lost(&format!("its process has died {ATTEMPTS} times: {ended}"));
        Ok(Some(Finished { row, picture: None }))
    }

    fn begin(&self, program: &Path) -> io::Result<Worker> {
        let mut process = Process::new(program);
        process.arg("sweep-worker");
        if let Some(device) = &self.device {
            process.args(["--device", device]);
        }
        if let Some(threads) = self.threads {
            for name in ["LP_NUM_THREADS", "RAYON_NUM_THREADS"] {
                if std::env::var_os(name).is_none() {
                    process.env(name, threads.to_string());
                }
            }
        }
        // Ctrl-C in a terminal goes to its whole group; the runs under way are to be finished.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut process, 0);
        let mut child = process
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let (to, from) = (child.stdin.take(), child.stdout.take());
        Ok(Worker {
            child,
            to,
            from: BufReader::new(from.expect("it is piped")),
        })
    }
}

/// What a process writes for each run: [`MARK`], this as a line of JSON, and after it the bytes of the picture.
#[derive(Debug, Serialize, Deserialize)]
struct Answer {
    row: Row,
    /// How many bytes, or why there is none.
    picture: Option<Result<usize, String>>,
}

/// A process that does one run after the other.
struct Worker {
    child: Child,
    to: Option<ChildStdin>,
    from: BufReader<ChildStdout>,
}

impl Worker {
    /// Does a run; if the process has died, how it ended.
    fn run(mut self, job: &Job) -> Result<(Finished, Self), String> {
        let mut line = serde_json::to_string(job).expect("it is plain");
        line.push('\n');
        let to = self.to.as_mut().expect("it is open");
        let sent = to.write_all(line.as_bytes()).and_then(|()| to.flush());
        match sent.and_then(|()| answer(&mut self.from, console::message_over_line)) {
            Ok(finished) => Ok((finished, self)),
            Err(_) => {
                let _ = self.child.kill();
                let ended = self.child.wait();
                Err(ended.map_or_else(|error| error.to_string(), |status| status.to_string()))
            }
        }
    }
}

/// Reads what a process has written for a run. `show` gets what layers and drivers have printed before it.
fn answer(from: &mut impl BufRead, mut show: impl FnMut(&str)) -> io::Result<Finished> {
    let json = loop {
        let mut line = Vec::new();
        if from.read_until(b'\n', &mut line)? == 0 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        let mut places = line.windows(MARK.len());
        let place = places.position(|part| part == MARK.as_bytes());
        // What is printed may end without a line break.
        let printed = &line[..place.unwrap_or(line.len())];
        let printed = String::from_utf8_lossy(printed).trim_end().to_owned();
        if !printed.is_empty() {
            show(&printed);
        }
        if let Some(place) = place {
            break line.split_off(place + MARK.len());
        }
    };
    let Answer { row, picture } = serde_json::from_slice(&json)?;
    let mut read = |length| {
        let mut bytes = vec![0; length];
        from.read_exact(&mut bytes).map(|()| bytes)
    };
    let picture = match picture {
        Some(Ok(length)) => Some(Ok(read(length)?)),
        Some(Err(why)) => Some(Err(why)),
        None => None,
    };
    Ok(Finished { row, picture })
}

impl Drop for Worker {
    fn drop(&mut self) {
        // At the end of its input it ends.
        self.to = None;
        let _ = self.child.wait();
    }
}

/// Do jobs of `myxo sweep`, from the standard input
#[derive(Clone, Debug, Args)]
#[command(hide = true)]
pub struct SweepWorker {
    /// The device
    #[arg(long, value_name = "N|NAME")]
    device: Option<String>,
}

impl Command for SweepWorker {
    fn run(&self) -> Result<Outcome> {
        let mut ctx = None;
        let (give, lines) = channel();
        thread::spawn(move || {
            for line in io::stdin().lines().map_while(Result::ok) {
                let _ = give.send(line);
            }
            // The sweep has ended, perhaps in the middle of a run, for which nothing waits.
            std::process::exit(0);
        });
        for line in lines {
            let job: Job = serde_json::from_str(&line)
                .map_err(|error| Error::Invalid(format!("this is no job of a sweep: {error}")))?;
            let Finished { row, picture } = match &ctx {
                Some(ctx) => job.run(ctx),
                None => match open(self.device.clone()) {
                    Ok(opened) => job.run(ctx.insert(opened)),
                    Err(error) => Finished {
                        row: job.lost(&error.to_string()),
                        picture: None,
                    },
                },
            };
            // After an error the device may be lost: the next run opens it again.
            if row.failed() || matches!(picture, Some(Err(_))) {
                ctx = None;
            }
            let length = |picture: &Picture| picture.as_ref().map(Vec::len).map_err(Clone::clone);
            let answer = Answer {
                row,
                picture: picture.as_ref().map(length),
            };
            let answer = serde_json::to_string(&answer).expect("it is plain");
            console::print(format!("{MARK}{answer}\n"))?;
            if let Some(Ok(picture)) = &picture {
                console::write(picture)?;
            }
        }
        Ok(Outcome::Done)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Would catch: a line that a layer or a driver prints and that is taken for an answer, by which its process is killed.
    #[test]
    fn lines_that_drivers_print_are_no_answers() {
        let of_run = |run: u64, picture: Option<Result<usize, String>>| {
            let mut row = Row::default();
            row.set("run", run);
            let json = serde_json::to_string(&Answer { row, picture }).expect("it is plain");
            format!("{MARK}{json}\n").into_bytes()
        };
        let parts: [&[u8]; 6] = [
            b"a layer is here\n\n{\"row\": \xff}\n",
            &of_run(1, Some(Ok(4))),
            b"\n\nPN",
            b"a driver has no line break: ",
            &of_run(2, Some(Err("no room".to_owned()))),
            b"the end\n",
        ];
        let written = parts.concat();
        let mut from = &written[..];
        let mut shown = Vec::new();
        let mut next = || answer(&mut from, |line| shown.push(line.to_owned()));
        let first = next().expect("it is there");
        assert_eq!(first.row.get("run").and_then(|run| run.as_u64()), Some(1));
        assert_eq!(first.picture, Some(Ok(b"\n\nPN".to_vec())));
        let second = next().expect("it is there");
        assert_eq!(second.row.get("run").and_then(|run| run.as_u64()), Some(2));
        assert_eq!(second.picture, Some(Err("no room".to_owned())));
        let error = next().expect_err("the process has ended");
        assert_eq!(error.kind(), io::ErrorKind::UnexpectedEof);
        let expected = [
            "a layer is here",
            "{\"row\": \u{fffd}}",
            "a driver has no line break:",
            "the end",
        ];
        assert_eq!(shown, expected);
    }
}
